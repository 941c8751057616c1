"""The open edges of a surface: where moving it changes a flux by more than what passes through its faces.

A flux of F through a surface that moves by v changes by the integral of div F (v . n) over the surface plus the
line integral of F x v along its border. Inner edges cancel, being walked once each way; what is left over are
borders, and edges where faces disagree about their side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from meshmark.mesh import FloatArray, IntArray

__all__ = ["EdgeSamples", "open_edges", "sample_open_edges"]

# An edge is split into this many pieces, and all edges into about this many samples, at most.
MAX_PIECES = 64
MAX_SAMPLES = 500_000


@dataclass(frozen=True, eq=False, kw_only=True)
class EdgeSamples:
    """Points on the open edges of a surface.

    positions: (e, 3); steps: (e, 3) piece of border that each stands for, as a vector along it.
    motion:    (e, p) weights of the points at the edge's ends, so that motion @ v is the motion of the samples.
    """

    positions: FloatArray
    steps: FloatArray
    motion: sp.csr_array


def sample_open_edges(points: FloatArray, faces: IntArray, longest: float) -> EdgeSamples:
    """Return samples of the open edges, no piece longer than `longest`."""
    start, end, excess = open_edges(faces, len(points))
    along = points[end] - points[start]
    length = np.sqrt(np.einsum("ij,ij->i", along, along))
    pieces = np.clip(np.ceil(length / longest), 1, MAX_PIECES).astype(np.int64)
    crowding = float(pieces.sum()) / MAX_SAMPLES
    if crowding > 1.0:
        pieces = np.clip(np.ceil(length / (longest * crowding)), 1, MAX_PIECES).astype(np.int64)
    edge = np.repeat(np.arange(len(start)), pieces)
    first = np.cumsum(pieces) - pieces
    place = (np.arange(len(edge)) - first[edge] + 0.5) / pieces[edge]
    rows = np.arange(len(edge))
    motion = sp.csr_array(
        (
            np.concatenate([1.0 - place, place]),
            (np.concatenate([rows, rows]), np.concatenate([start[edge], end[edge]])),
        ),
        shape=(len(edge), len(points)),
    )
    steps = along[edge] * (excess[edge] / pieces[edge])[:, None]
    return EdgeSamples(
        positions=points[start[edge]] + place[:, None] * along[edge], steps=steps, motion=motion
    )


def open_edges(faces: IntArray, count: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Return start and end of each open edge, and how much oftener it is walked this way: (e,) each."""
    name = np.empty((3, len(faces)), np.int64)  # of the edge, and in the last bit the way it is walked
    for side, (start, end) in zip(name, ((0, 1), (1, 2), (2, 0)), strict=True):
        np.minimum(faces[:, start], faces[:, end], out=side)
        side *= count
        side += np.maximum(faces[:, start], faces[:, end])
        side <<= 1
        side |= faces[:, start] < faces[:, end]
    flat = name.reshape(-1)
    flat.sort()
    way = (2 * (flat & 1) - 1).astype(np.int8)
    flat >>= 1
    new = np.ones(len(flat), bool)
    np.not_equal(flat[1:], flat[:-1], out=new[1:])
    first = np.flatnonzero(new)
    excess = np.add.reduceat(way, first, dtype=np.int64) if len(first) else np.zeros(0, np.int64)
    is_open = np.flatnonzero(excess)
    starts, ends = np.divmod(flat[first[is_open]], count)
    return starts, ends, excess[is_open].astype(np.float64)

"""The vertex graph of a mesh: its edges, who is next to whom, and sweeps over rings of neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.mesh import FloatArray, IntArray

__all__ = ["adjacency", "joined", "mean_squared_edge", "ring_maximum", "unique_edges"]


def unique_edges(faces: IntArray) -> IntArray:
    """Return (e, 2): each undirected edge once, smaller index first, sorted; a point is no edge."""
    key = np.empty((3, len(faces)), np.int64)  # one sortable number for an edge, in place
    for side, (start, end) in zip(key, ((0, 1), (1, 2), (2, 0)), strict=True):
        np.minimum(faces[:, start], faces[:, end], out=side)
        side <<= 32
        side |= np.maximum(faces[:, start], faces[:, end])
    flat = key.reshape(-1)
    flat.sort()
    new = np.ones(len(flat), bool)
    np.not_equal(flat[1:], flat[:-1], out=new[1:])
    flat = flat[new]
    edges = np.stack([flat >> 32, flat & 0xFFFFFFFF], axis=1)
    proper = edges[:, 0] != edges[:, 1]
    return edges if proper.all() else edges[proper]


def adjacency(edges: IntArray, count: int) -> csr_array:
    """Return the symmetric (count, count) matrix with 1.0 at both places of each edge, indices sorted."""
    both = joined(edges, count)
    return csr_array((np.ones(both.nnz), both.indices, both.indptr), shape=both.shape)


def joined(edges: IntArray, count: int) -> csr_array:
    """Return the matrix of `adjacency` with 8-bit integers, which take an eighth of the room."""
    start = np.searchsorted(edges[:, 0], np.arange(count + 1)).astype(np.int32)
    upper = csr_array(
        (np.ones(len(edges), np.int8), edges[:, 1].astype(np.int32), start), shape=(count, count)
    )
    return csr_array(upper + upper.T)


def mean_squared_edge(points: FloatArray, edges: IntArray) -> float:
    """Return the mean squared length of the edges, 0.0 where there is none."""
    steps = points.take(edges[:, 0], axis=0) - points.take(edges[:, 1], axis=0)
    return float(np.vdot(steps, steps)) / max(len(edges), 1)


def ring_maximum(values: NDArray[Any], graph: csr_array, rings: int) -> NDArray[Any]:
    """Return at each point the largest of `values` (p,) over all points at most `rings` edges away."""
    occupied = np.diff(graph.indptr) > 0
    starts = graph.indptr[:-1][occupied]
    best = np.array(values)
    for _ in range(rings if len(starts) else 0):
        around = np.maximum.reduceat(best.take(graph.indices), starts)
        best[occupied] = np.maximum(best[occupied], around)
    return best

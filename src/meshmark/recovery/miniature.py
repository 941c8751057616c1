"""A model's surface in a given number of bytes, in canonical coordinates (docs/design.md, section 8)."""

from __future__ import annotations

import numpy as np

from meshmark.errors import CapacityError, InputError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import face_areas
from meshmark.geometry.components import connected_components
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.mesh_coder import PLACE_BITS, decode_mesh, encode_mesh, estimated_size
from meshmark.recovery.simplify import Simplification

__all__ = ["SMALLEST", "miniature", "read_miniature"]

SMALLEST = 40
"""Bytes of the smallest miniature that is made."""
LARGEST_POINTS = 4000
# Fewest bits of a point in a miniature, connections included; how often the number of points is corrected, and
# which share of the bytes a correction aims at.
BITS_OF_POINT, TRIES, AIM = 12.0, 10, 0.985
# Points, or a quarter of them, from which the bytes of all are estimated.
SAMPLE = 300
# Quantiser steps along the RMS size of a surface by its number of points, factor and exponent: rounding is to be a
# little less than what simplification changes. Measured: docs/decisions/0032.
STEPS, GROWTH = 0.45, 0.87
# Steps are 2^(-scale / 4); the scales that are used, and what is added to them in the first byte, which so differs
# from that of earlier versions.
SCALES, FIRST = range(4, 53), 64
# By how much the scale falls where a part cannot get simpler.
COARSER = 2
_QUARTERS = (1.0, 1.189207115002721, 1.4142135623730951, 1.681792830507429)


def miniature(points: FloatArray, faces: IntArray, size_bytes: int, *, frame: Frame | None = None) -> bytes:
    """Return the surface in at most `size_bytes` bytes, in the canonical coordinates of its own frame.

    Of many parts that do not fit the smallest are left out. points: (p, 3); faces: (m, 3);
    frame: the surface's canonical frame, where it is known already. Raises `CapacityError`
    where the bytes are too few even for a crude shape, `InputError` where there is no surface.
    """
    if size_bytes >= SMALLEST:
        canonical = (frame or canonical_frame(points, faces)).to_canonical(points)
        count = max(min(int(8 * size_bytes / BITS_OF_POINT), LARGEST_POINTS), 4)
        simpler = Simplification(canonical, faces, count)
        few, small = simpler.to(count)
        size, finest = _size(few, small) if len(small) else 0.0, SCALES.stop
        for _ in range(TRIES):
            count, before = max(int(len(few) * min(AIM * size_bytes / max(size, 1.0), 1.0)), 4), len(few)
            if count < len(few):
                few, small = simpler.to(count)
                if len(few) > 1.03 * count:  # parts that cannot get simpler: the smallest go
                    few, small = _largest_parts(few, small, count)
                    simpler = Simplification(few, small, len(few))
            if not len(small):
                break
            if size > size_bytes and len(few) == before:  # the largest part cannot get simpler: coarser steps
                finest = min(_scale(few), finest) - COARSER
            content = _encoded(few, small, finest)
            if len(content) <= size_bytes:
                return content
            size = float(len(content))
    raise CapacityError(
        f"a miniature of the model does not fit the {size_bytes} bytes that the model has room for"
    )


def _largest_parts(points: FloatArray, faces: IntArray, count: int) -> tuple[FloatArray, IntArray]:
    """Return the connected parts of most area, about `count` points in all, at least one part."""
    part = connected_components(adjacency(unique_edges(faces), len(points)))[1]
    area = np.bincount(part[faces[:, 0]], face_areas(points, faces), part.max() + 1)
    order = np.argsort(-area, kind="stable")
    kept = order[: max(int((np.cumsum(np.bincount(part)[order]) <= count).sum()), 1)]
    stays = np.isin(part, kept)
    number = np.cumsum(stays) - 1
    return points[stays], number[faces[stays[faces[:, 0]]]]


def _encoded(points: FloatArray, faces: IntArray, finest: int) -> bytes:
    scale = max(min(_scale(points), finest), SCALES.start)
    return bytes([FIRST + scale]) + encode_mesh(points * _steps(scale), faces)


def _size(points: FloatArray, faces: IntArray) -> float:
    """Return about how many bytes `_encoded` takes."""
    return estimated_size(points * _steps(_scale(points)), faces, max(SAMPLE, len(points) // 4))


def _scale(points: FloatArray) -> int:
    # Parts far away must stay within the coder's reach.
    most = (2.0**PLACE_BITS - 1.0) / float(np.abs(points).max(initial=1.0))
    wanted = min(STEPS * max(len(points), 1) ** GROWTH, most)
    return max((each for each in SCALES if _steps(each) <= wanted), default=SCALES.start)


def _steps(scale: int) -> float:
    """Return 2^(scale / 4), the same on every machine."""
    return _QUARTERS[scale % 4] * 2.0 ** (scale // 4)


def read_miniature(content: bytes) -> tuple[FloatArray, IntArray]:
    """Return points (p, 3) and faces (m, 3) in canonical coordinates; raises `InputError` for damaged content."""
    if not content or content[0] - FIRST not in SCALES:
        raise InputError("the bytes are no miniature, expected one that this version of meshmark made")
    places, faces = decode_mesh(content[1:])
    if not len(faces):
        raise InputError("the miniature has no faces, expected a surface")
    return places / _steps(content[0] - FIRST), faces

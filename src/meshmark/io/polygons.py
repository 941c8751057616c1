"""Polygons of a file as triangles for the maths; the file keeps its polygons."""

from __future__ import annotations

import numpy as np

from meshmark.arrays import members
from meshmark.errors import FormatError
from meshmark.mesh import IntArray

__all__ = ["check_indices", "fan_corners", "strip_triangles"]


def fan_corners(sizes: IntArray) -> IntArray:
    """Return (m, 3) places in the flat list of corners that make each polygon a fan of triangles.

    sizes: (p,) corners per polygon. Polygons of one or two corners have no area and give no triangle.
    """
    if (sizes == 3).all():
        return np.arange(3 * len(sizes)).reshape(-1, 3)
    begin = np.cumsum(sizes) - sizes
    group, place = members(np.maximum(sizes - 2, 0))
    apex = begin[group]
    return np.stack([apex, apex + place + 1, apex + place + 2], axis=1)


def strip_triangles(strip: IntArray) -> IntArray:
    """Return the (m, 3) triangles of a list of triangle strips that -1 parts, windings made equal."""
    if len(strip) < 3:
        return np.empty((0, 3), dtype=np.int64)
    corners = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    begins = np.maximum.accumulate(np.where(strip == -1, np.arange(len(strip)) + 1, 0))[:-2]
    odd = (np.arange(len(corners)) - begins) % 2 == 1
    corners[odd] = corners[odd][:, [1, 0, 2]]
    return corners[(corners >= 0).all(axis=1)]


def check_indices(corners: IntArray, vertices: int, what: str = "a face") -> None:
    """Raise `FormatError` unless all corners are vertex indices, 0 to vertices - 1."""
    if corners.size and (corners.min() < 0 or corners.max() >= vertices):
        bad = corners[(corners < 0) | (corners >= vertices)].flat[0]
        raise FormatError(f"{what} refers to vertex {bad}, expected 0 to {vertices - 1}")

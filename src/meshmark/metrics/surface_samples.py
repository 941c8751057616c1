"""Evenly spread samples of the edges and faces of a surface; the same surface gives the same samples."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import face_areas
from meshmark.mesh import FloatArray, IntArray

__all__ = ["STEPS", "sample_edges", "sample_faces"]

# Steps of the additive sequence that fills the unit square most evenly: powers of the plastic number.
STEPS = np.array([0.7548776662466927, 0.5698402909980532])


def sample_faces(points: FloatArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count, 3) points spread over the surface, the same number for each share of its area."""
    face = _pick(face_areas(points, faces), count)
    u, v = ((np.arange(count)[:, None] + 0.5) * STEPS % 1.0).T
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = (points[faces[face, i]] for i in range(3))
    return np.asarray(a + u[:, None] * (b - a) + v[:, None] * (c - a))


def sample_edges(points: FloatArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count, 3) points spread along all edges, the same number for each share of their length."""
    start, end = (points[column] for column in unique_edges(faces).T)
    edge = _pick(np.linalg.norm(end - start, axis=1), count)
    along = ((np.arange(count) + 0.5) * STEPS[0] % 1.0)[:, None]
    return np.asarray(start[edge] + along * (end - start)[edge])


def _pick(sizes: FloatArray, count: int) -> IntArray:
    """Return (count,) rows, each as often as its size asks for, at equal steps of the running total."""
    total = np.cumsum(sizes)
    if not total[-1] > 0.0:  # nothing has a size: all alike
        return np.asarray((np.arange(count) * len(sizes)) // count, np.int64)
    picked = np.searchsorted(total, (np.arange(count) + 0.5) * (total[-1] / count), side="right")
    return np.asarray(np.minimum(picked, len(sizes) - 1), np.int64)

"""What tests of recovery ask of surfaces: their faces as sets, their characteristic, and distances to them."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.mesh import FloatArray, IntArray


def turned_first(faces: IntArray) -> list[tuple[int, ...]]:
    """Return the faces, each from its smallest corner on, sorted."""
    return sorted(tuple(np.roll(face, -int(np.argmin(face))).tolist()) for face in faces)


def euler(faces: IntArray) -> int:
    """Return points - edges + faces of what the faces use."""
    return len(np.unique(faces)) - len(unique_edges(faces)) + len(faces)


def off(points: FloatArray, faces: IntArray, places: FloatArray) -> FloatArray:
    """Return how far each place lies off a surface."""
    return SurfaceIndex(points, faces).nearest(places).distances


def area_vector(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return the sum of the faces' area vectors: what a border determines, whatever surface it has."""
    a, b, c = points[faces].transpose(1, 0, 2)
    return 0.5 * np.cross(b - a, c - a).sum(axis=0)


def area(points: FloatArray, faces: IntArray) -> float:
    """Return the area of the faces."""
    a, b, c = points[faces].transpose(1, 0, 2)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def grid(across: int) -> tuple[FloatArray, IntArray]:
    """A flat square of side 1, across x across points, seen from above."""
    axis = np.linspace(0.0, 1.0, across)
    points = np.stack(np.meshgrid(axis, axis, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = (np.arange(across - 1)[:, None] * across + np.arange(across - 1)).ravel()
    one = np.column_stack([corner, corner + across, corner + 1])
    other = np.column_stack([corner + across, corner + across + 1, corner + 1])
    return points, np.concatenate([one, other])

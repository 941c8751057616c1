"""Areas and normals of triangles and of the points they meet at."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["area_vectors", "face_areas", "sum_at_points", "vertex_areas", "vertex_normals"]


def area_vectors(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m, 3): the normal of each face times its area, half the cross product of two edges."""
    corners = np.ascontiguousarray(faces.T)
    axes = np.ascontiguousarray(points.T)
    a, b, c = ([axis.take(corner) for axis in axes] for corner in corners)  # far faster than rows
    u = [q - p for p, q in zip(a, b, strict=True)]
    v = [q - p for p, q in zip(a, c, strict=True)]
    out = np.empty((len(faces), 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # twice as fast as np.cross
        out[:, i] = 0.5 * (u[j] * v[k] - u[k] * v[j])
    return out


def face_areas(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m,): the area of each face."""
    vectors = area_vectors(points, faces)
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def sum_at_points(values: FloatArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count,): at each point the sum of `values` (m,) over the faces that meet there."""
    out = np.zeros(count)
    for corner in faces.T:
        out += np.bincount(corner, weights=values, minlength=count)
    return out


def vertex_areas(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (p,): a third of the area of the faces that meet at each point; 0 where none does."""
    return sum_at_points(face_areas(points, faces) / 3.0, faces, len(points))


def vertex_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (p, 3): unit normals, area-weighted over the faces at each point; (0, 0, 0) where they cancel."""
    vectors = area_vectors(points, faces)
    normals = np.stack([sum_at_points(axis, faces, len(points)) for axis in vectors.T], axis=1)
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    length[length == 0.0] = 1.0
    return normals / length[:, None]

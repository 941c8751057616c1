"""Areas and normals of triangles and of the points they meet at."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

try:  # what scipy itself multiplies with; called directly it adds onto an array instead of making a new one
    from scipy.sparse._sparsetools import csc_matvecs
except ImportError:  # it is private and may move
    csc_matvecs = None  # type: ignore[assignment]

__all__ = [
    "add_at_points",
    "area_fluxes",
    "area_vectors",
    "cross_by_axis",
    "face_areas",
    "face_lengths",
    "sum_at_points",
    "vertex_area_sums",
    "vertex_areas",
    "vertex_areas_and_normals",
    "vertex_normals",
]


def area_vectors(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m, 3): the normal of each face times its area, half the cross product of two edges."""
    out = np.empty((len(faces), 3))
    for part in blocks(len(faces)):
        a = points.take(faces[part, 0], axis=0)  # `take` gathers rows three times as fast as indexing
        u = points.take(faces[part, 1], axis=0)
        u -= a
        v = points.take(faces[part, 2], axis=0)
        v -= a
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # twice as fast as np.cross
            out[part, i] = u[:, j] * v[:, k] - u[:, k] * v[:, j]
    out *= 0.5
    return out


def face_areas(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m,): the area of each face."""
    areas = np.empty(len(faces))
    for part in blocks(len(faces)):
        areas[part] = _lengths(area_vectors(points, faces[part]))
    return areas


def sum_at_points(values: FloatArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count,) or (count, k): at each point the sum of `values` (m,) or (m, k) of the faces there."""
    sums = np.zeros((count, *values.shape[1:]))
    for part in blocks(len(faces)):
        add_at_points(sums, values[part], faces[part])
    return sums


def add_at_points(sums: FloatArray, values: FloatArray, faces: IntArray) -> None:
    """Add `values` (m,) or (m, k) of faces (m, c) to `sums` (p,) or (p, k) at each of their points, in order.

    Face by face: the sums are the same, bit by bit, however many faces are added at a time.
    """
    starts = np.arange(0, faces.size + 1, faces.shape[1], dtype=np.int32)  # the type scipy would convert to
    corners, ones = faces.ravel().astype(np.int32), np.ones(faces.size)
    if csc_matvecs is None:
        np.add.at(sums, faces, values[:, None])
    else:
        columns, given = sums.size // max(len(sums), 1), np.ascontiguousarray(values, np.float64).reshape(-1)
        csc_matvecs(len(sums), len(faces), columns, starts, corners, ones, given, sums.reshape(-1))


def vertex_areas(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (p,): a third of the area of the faces that meet at each point; 0 where none does."""
    return sum_at_points(face_areas(points, faces) / 3.0, faces, len(points))


def face_lengths(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m,): the longest edge of each face, in the unit of the points (p, 3)."""
    out = np.empty(len(faces))
    for part in blocks(len(faces)):
        corners = [points.take(faces[part, i], axis=0) for i in range(3)]
        steps = (corners[i] - corners[i - 1] for i in range(3))
        out[part] = np.sqrt(np.max([np.einsum("ij,ij->i", step, step) for step in steps], axis=0))
    return out


def vertex_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (p, 3): unit normals, area-weighted over the faces at each point; zeros where they cancel."""
    return _unit(vertex_area_sums(points, faces)[1])


def vertex_areas_and_normals(points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return `vertex_areas` (p,) and `vertex_normals` (p, 3) for little more than the price of one."""
    areas, vectors = vertex_area_sums(points, faces)
    return areas, _unit(vectors)


def vertex_area_sums(points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return `vertex_areas` (p,), and the sum (p, 3) of the area vectors of the faces at each point."""
    sums = np.zeros((len(points), 4))
    for part in blocks(len(faces)):
        add_at_points(sums, area_fluxes(points, faces[part]), faces[part])
    return sums[:, 3] / 3.0, sums[:, :3]


def area_fluxes(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m, 4): the area vector of each face, and its area."""
    both = np.empty((len(faces), 4))
    both[:, :3] = area_vectors(points, faces)
    both[:, 3] = _lengths(both[:, :3])
    return both


def cross_by_axis(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the cross products of vectors whose coordinates come first, (3, ...) each."""
    return np.stack([one[i] * other[j] - one[j] * other[i] for i, j in ((1, 2), (2, 0), (0, 1))])


def _unit(vectors: FloatArray) -> FloatArray:
    length = _lengths(vectors)
    length[length == 0.0] = 1.0
    unit = np.empty(vectors.shape)
    for axis in range(3):  # column by column: three times as fast as rows of three numbers
        np.divide(vectors[:, axis], length, out=unit[:, axis])
    return unit


def _lengths(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return lengths

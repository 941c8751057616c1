from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import (
    area_vectors,
    face_areas,
    vertex_areas,
    vertex_areas_and_normals,
    vertex_normals,
)
from meshmark.mesh import FloatArray, IntArray

RNG = np.random.default_rng(3)


def octahedron() -> tuple[FloatArray, IntArray]:
    points = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], float)
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    return points, faces


def test_area_vectors_equal_numpy_cross() -> None:
    points, faces = RNG.normal(size=(50, 3)), RNG.integers(0, 50, (80, 3))
    a, b, c = points[faces].transpose(1, 0, 2)
    np.testing.assert_allclose(area_vectors(points, faces), np.cross(b - a, c - a) / 2, atol=1e-14)


def test_a_closed_surface_has_no_net_area_vector() -> None:
    points, faces = octahedron()
    moved = points + 0.3 * RNG.normal(size=points.shape)
    np.testing.assert_allclose(area_vectors(moved, faces).sum(axis=0), 0.0, atol=1e-15)


def test_vertex_areas_share_out_the_whole_area() -> None:
    points, faces = octahedron()
    moved = points + 0.3 * RNG.normal(size=points.shape)
    np.testing.assert_allclose(vertex_areas(moved, faces).sum(), face_areas(moved, faces).sum())
    np.testing.assert_allclose(vertex_areas(points, faces), 4 * np.sqrt(3) / 2 / 3)


def test_normals_of_the_octahedron_are_its_corners() -> None:
    points, faces = octahedron()
    np.testing.assert_allclose(vertex_normals(points, faces), points, atol=1e-15)


def test_points_without_area_get_a_zero_normal() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], float)
    assert not vertex_normals(points, np.array([[0, 1, 2]])).any()
    assert vertex_normals(points, np.zeros((0, 3), np.int64)).shape == (4, 3)


def test_areas_and_normals_together_equal_each_alone() -> None:
    points, faces = RNG.normal(size=(20, 3)), RNG.integers(0, 20, (50, 3))
    areas, normals = vertex_areas_and_normals(points, faces)
    np.testing.assert_allclose(areas, vertex_areas(points, faces))
    np.testing.assert_allclose(normals, vertex_normals(points, faces))

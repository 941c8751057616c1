"""Smooth functions on a surface."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.surface_basis import surface_basis
from tests.shapes import pebble

POINTS, FACES = pebble(40)
NORMALS = vertex_normals(POINTS, FACES)
PITCH = 0.3


def test_the_functions_add_up_to_one():
    basis = surface_basis(POINTS, NORMALS, PITCH)
    np.testing.assert_allclose(basis.sum(axis=1), 1.0)
    assert (basis.data >= 0.0).all()
    assert basis.shape[1] < len(POINTS)


def test_smooth_values_are_met_closely_and_noise_is_not():
    basis = surface_basis(POINTS, NORMALS, PITCH).toarray()
    smooth = np.sin(POINTS @ [1.0, 0.5, 0.2])
    noise = np.random.default_rng(1).normal(size=len(POINTS))

    def left(values):
        fit = np.linalg.lstsq(basis, values, rcond=None)[0]
        return np.linalg.norm(basis @ fit - values) / np.linalg.norm(values)

    assert left(smooth) < 0.02
    assert left(noise) > 0.5


def test_the_sides_of_a_thin_wall_share_no_function():
    grid = np.array([[x, y, 0.0] for x in np.linspace(0, 2, 15) for y in np.linspace(0, 2, 15)])
    points = np.concatenate([grid, grid + np.array([0.0, 0.0, 0.01])])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], len(grid), axis=0)
    basis = surface_basis(points, normals, PITCH).toarray() > 0.0
    assert not (basis[: len(grid)].any(axis=0) & basis[len(grid) :].any(axis=0)).any()


def test_a_coarse_mesh_has_a_function_of_its_own_for_each_point():
    points, faces = pebble(16)
    basis = surface_basis(points, vertex_normals(points, faces), 1e-3)
    np.testing.assert_allclose(basis.toarray() @ np.ones(basis.shape[1]), 1.0)
    assert basis.shape == (len(points), len(points))

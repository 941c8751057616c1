"""Finite elements on a triangle mesh."""

from __future__ import annotations

import numpy as np

from meshmark.geometry import stiffness as module
from meshmark.geometry.areas import face_areas, vertex_areas
from meshmark.geometry.stiffness import diffused, stiffness
from tests.shapes import pebble

POINTS, FACES = pebble(24)


def test_the_energy_of_a_linear_function_on_a_plane_is_area_times_slope_squared():
    grid = np.array([[x, y, 0.0] for x in range(5) for y in range(5)])
    grid[:, :2] += 0.1 * np.random.default_rng(1).random((25, 2))
    corners = [(5 * x + y, 5 * x + y + 5, 5 * x + y + 6, 5 * x + y + 1) for x in range(4) for y in range(4)]
    faces = np.array([half for a, b, c, d in corners for half in ((a, b, c), (a, c, d))])
    slope = np.array([0.7, -1.3, 0.0])
    values = grid @ slope
    energy = values @ stiffness(grid, faces) @ values
    assert np.isclose(energy, face_areas(grid, faces).sum() * (slope @ slope))


def test_weights_scale_the_energy_of_their_faces():
    weights = np.random.default_rng(2).random(len(FACES))
    values = np.sin(POINTS @ [1.0, 2.0, 3.0])
    whole = values @ stiffness(POINTS, FACES, weights) @ values
    parts = sum(
        weight * (values @ stiffness(POINTS, FACES[[face]]) @ values)
        for face, weight in enumerate(weights[:200])
    )
    rest = values @ stiffness(POINTS, FACES[200:], weights[200:]) @ values
    # Needle triangles are bounded by the mean area of what is there, so the sums agree only about.
    assert np.isclose(whole, parts + rest, rtol=1e-3)


def test_diffusion_keeps_constants_and_the_mean_and_damps_detail():
    mass = vertex_areas(POINTS, FACES)
    stiff = stiffness(POINTS, FACES)
    rough = np.random.default_rng(3).normal(size=len(POINTS))
    smooth, constant = diffused(np.column_stack([rough, np.ones(len(POINTS))]), mass, stiff, 0.2).T
    np.testing.assert_allclose(constant, 1.0, atol=2e-3)
    assert abs(smooth @ mass - rough @ mass) < 5e-3 * (np.abs(rough) @ mass)
    assert smooth.std() < 0.5 * rough.std()


def test_diffusion_of_a_wider_gaussian_damps_a_wave_as_it_should():
    """On a sphere the coordinates are eigenfunctions of the Laplacian, eigenvalue 2."""
    points = POINTS / np.linalg.norm(POINTS, axis=1)[:, None]
    mass, stiff = vertex_areas(points, FACES), stiffness(points, FACES)
    width = 0.4
    left = diffused(points, mass, stiff, width)
    # Two implicit Euler steps of half of width^2 / 2 each.
    expected = points / (1.0 + 2.0 * width**2 / 4.0) ** 2
    np.testing.assert_allclose(left, expected, atol=0.02)


def test_diffusion_does_not_depend_on_how_many_points_are_taken_at_a_time(monkeypatch):
    mass, stiff = vertex_areas(POINTS, FACES), stiffness(POINTS, FACES)
    rough = np.random.default_rng(4).normal(size=(len(POINTS), 2))
    whole = diffused(rough, mass, stiff, 0.2)
    monkeypatch.setattr(module, "BLOCK", 7)
    assert len(POINTS) > 100
    np.testing.assert_array_equal(diffused(rough, mass, stiff, 0.2), whole)
    assert np.abs(whole - rough).max() > 0.1

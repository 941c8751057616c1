from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import vertex_normals
from meshmark.recovery.miniature_projection import MiniatureProjection, spreads
from tests.recovery.surfaces import grid, off
from tests.shapes import pebble


def projection_of(
    points: np.ndarray, faces: np.ndarray, altered: np.ndarray, mini: tuple
) -> MiniatureProjection:
    return MiniatureProjection(points, faces, adjacency(unique_edges(faces), len(points)), altered, mini)


@pytest.fixture(scope="module")
def dented() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A pebble, the same with a smooth bump, its faces, and which points the bump moved."""
    points, faces = pebble(48)
    centre = points[len(points) // 2]
    height = 0.15 * np.maximum(1.0 - np.square((points - centre) / 0.5).sum(axis=1), 0.0) ** 2
    return points, points + height[:, None] * vertex_normals(points, faces), faces, height > 0.0


def test_a_bump_goes_back_to_the_true_surface(dented):
    points, bumped, faces, altered = dented
    projection = projection_of(bumped, faces, altered, (points, faces))
    before = off(points, faces, bumped)[altered]
    drawn = projection.project(altered)
    after = off(points, faces, drawn)[altered]
    assert before.max() > 0.1
    assert np.sqrt((after**2).mean()) < 0.1 * np.sqrt((before**2).mean())
    assert np.array_equal(drawn[~altered], bumped[~altered])


def test_what_lies_on_the_true_surface_stays_there(dented):
    points, _, faces, altered = dented
    projection = projection_of(points, faces, altered, (points, faces))
    assert projection.distances().max() < 1e-12
    assert off(points, faces, projection.project(altered)).max() < 0.01


def test_only_what_is_moving_moves(dented):
    points, bumped, faces, altered = dented
    projection = projection_of(bumped, faces, altered, (points, faces))
    assert np.array_equal(projection.project(np.zeros(len(points), bool)), bumped)
    some = altered & (np.arange(len(points)) % 2 == 0)
    moved = (projection.project(some) != bumped).any(axis=1)
    assert (moved <= some).all()
    assert moved.any()


def test_inputs_stay_as_they_are(dented):
    points, bumped, faces, altered = dented
    copy = bumped.copy()
    projection_of(bumped, faces, altered, (points, faces)).project(altered)
    assert np.array_equal(copy, bumped)


@pytest.mark.parametrize("height", [0.02, -0.3])
def test_a_miniature_that_is_off_by_a_constant_is_corrected_by_it(height):
    """A constant on the boundary is carried on as that constant: what is harmonic has no other values."""
    points, faces = grid(20)
    inner = (np.abs(points[:, :2] - 0.5) < 0.3).all(axis=1)
    wide = 3.0 * points - [1.0, 1.0, height]
    projection = projection_of(points, faces, inner, (wide, faces))
    np.testing.assert_allclose(
        projection.offset[inner], np.tile([0.0, 0.0, height], (inner.sum(), 1)), atol=1e-3 * abs(height)
    )
    assert projection.distances().max() < 1e-3 * abs(height)
    assert np.abs(projection.project(inner)[:, 2]).max() < 1e-3 * abs(height)


def test_a_correction_that_varies_lies_between_its_extremes_and_is_linear_where_the_rim_is():
    points, faces = grid(21)
    inner = (np.abs(points[:, :2] - 0.5) < 0.33).all(axis=1)
    tilt = 0.01
    steps = np.array([[-1.0, -1, 0], [2, -1, 0], [2, 2, 0], [-1, 2, 0]])
    steps[:, 2] = -tilt * steps[:, 0]
    projection = projection_of(points, faces, inner, (steps, np.array([[0, 1, 2], [0, 2, 3]])))
    expected = tilt * points[inner, 0]
    assert np.abs(projection.offset[inner, 2] - expected).max() < 0.05 * tilt
    held = projection.offset[~inner & (projection.offset != 0.0).any(axis=1), 2]
    assert held.min() <= projection.offset[inner, 2].min()
    assert projection.offset[inner, 2].max() <= held.max()


def test_spreads_are_roots_of_means_part_by_part():
    rng = np.random.default_rng(0)
    part, squares = rng.integers(0, 5, 300), rng.random(300)
    part[part == 3] = 4
    expected = [np.sqrt(squares[part == i].mean()) if (part == i).any() else 0.0 for i in range(6)]
    np.testing.assert_allclose(spreads(part, squares, 6), expected, rtol=1e-12)

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import face_areas
from meshmark.geometry.registration.surfels import low_passed, make_surfels
from tests.shapes import pebble

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def test_a_flat_square_keeps_its_area_moments_and_normal():
    pieces = make_surfels(CORNERS, SQUARE, 0.1)
    assert pieces.areas.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(pieces.areas @ pieces.places, [0.5, 0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(pieces.normals, np.tile([0.0, 0.0, 1.0], (len(pieces), 1)), atol=1e-12)
    assert len(pieces) >= 100


def test_two_sides_of_a_sheet_stay_apart():
    points = np.concatenate([CORNERS, CORNERS + np.array([0, 0, 1e-3])])
    pieces = make_surfels(points, np.concatenate([SQUARE[:, ::-1], SQUARE + 4]), 0.1)
    up = pieces.normals[:, 2] > 0.0
    np.testing.assert_allclose(np.abs(pieces.normals[:, 2]), 1.0)
    np.testing.assert_allclose(pieces.places[up, 2], 1e-3)
    np.testing.assert_allclose(pieces.places[~up, 2], 0.0, atol=1e-12)


def test_another_triangulation_gives_nearly_the_same_pieces():
    points, faces = pebble(48)
    corners = points[faces]
    middles = corners.mean(axis=1)
    finer = np.concatenate([points, middles])
    new = len(points) + np.arange(len(faces))
    split = np.concatenate([np.column_stack([faces[:, i], faces[:, (i + 1) % 3], new]) for i in range(3)])
    one, other = make_surfels(points, faces, 0.1), make_surfels(finer, split, 0.1)
    assert one.areas.sum() == pytest.approx(face_areas(points, faces).sum(), rel=0.02)
    assert other.areas.sum() == pytest.approx(one.areas.sum(), rel=0.01)
    distance, _ = one.tree.query(other.places)
    assert np.median(distance) < 0.02


def test_faces_without_area_give_nothing():
    assert len(make_surfels(CORNERS, np.array([[0, 1, 1], [2, 2, 2]]), 0.1)) == 0
    assert len(make_surfels(CORNERS, SQUARE[:0], 0.1)) == 0


def test_taking_some_pieces():
    pieces = make_surfels(CORNERS, SQUARE, 0.2)
    some = pieces.take(np.array([3, 1]))
    np.testing.assert_array_equal(some.places, pieces.places[[3, 1]])
    assert len(some) == 2


def test_the_low_pass_takes_off_noise_and_keeps_the_shape():
    points, faces = pebble(72)
    noisy = points + 0.02 * np.random.default_rng(0).normal(size=points.shape)
    left = low_passed(noisy, faces, 0.06) - low_passed(points, faces, 0.06)
    assert np.square(left).sum() < 0.5 * np.square(noisy - points).sum()
    distance, _ = make_surfels(points, faces, 0.02).tree.query(low_passed(points, faces, 0.06))
    assert np.quantile(distance, 0.95) < 0.03
    assert np.abs(low_passed(points, faces, 0.0) - points).max() < 1e-12
    np.testing.assert_array_equal(low_passed(points, faces[:0], 0.1), points)

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.registration.landmarks import LEAST_FLATNESS, WIDTH, spread
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.registration.windows import look
from tests.geometry.registering import lump, reference


def test_the_surface_lies_at_height_zero_over_each_landmark():
    points, faces = lump()
    landmarks, frame = reference()
    seen = look(PreparedSurface(points, faces, frame).fine, landmarks.places, landmarks.normals, WIDTH)
    assert np.abs(seen.heights).max() < 2e-3
    np.testing.assert_allclose(seen.masses, landmarks.masses)
    assert (seen.flatness > LEAST_FLATNESS).all()
    assert 0.5 < landmarks.explains <= 1.0


def test_landmarks_are_spread_each_farthest_from_those_before():
    rng = np.random.default_rng(0)
    facing = rng.normal(size=(200, 3))
    facing /= np.linalg.norm(facing, axis=1)[:, None]
    pieces = Surfels(places=rng.normal(size=(200, 3)), normals=facing, areas=np.ones(200))
    rows = spread(pieces, 20, 0.5)
    where = np.concatenate([pieces.places, 0.5 * facing], axis=1)
    for i in range(1, 20):
        gaps = np.linalg.norm(where[:, None] - where[rows[:i]], axis=2).min(axis=1)
        assert gaps[rows[i]] == pytest.approx(gaps.max())


def test_no_more_landmarks_than_pieces():
    none = Surfels(places=np.zeros((0, 3)), normals=np.zeros((0, 3)), areas=np.zeros(0))
    assert len(spread(none, 5, 0.1)) == 0
    one = Surfels(places=np.zeros((1, 3)), normals=np.array([[0.0, 0, 1]]), areas=np.ones(1))
    np.testing.assert_array_equal(spread(one, 5, 0.1), [0])

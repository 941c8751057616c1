from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshmark.geometry.registration.descriptors import DESCRIPTOR_LENGTH, SHELLS, describe, tangent_axes
from meshmark.geometry.registration.surfels import Surfels, make_surfels
from tests.counting import some
from tests.shapes import pebble


@pytest.fixture(scope="module")
def pieces() -> Surfels:
    return make_surfels(*pebble(60), 0.08)


def test_rotation_and_scale_change_nothing(pieces):
    rows = np.arange(0, len(pieces), 20)
    before = describe(pieces, pieces.places[rows], pieces.normals[rows], 0.5)
    turn = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix().T
    moved = Surfels(
        places=3.0 * pieces.places @ turn + 7.0, normals=pieces.normals @ turn, areas=9.0 * pieces.areas
    )
    after = describe(moved, moved.places[rows], moved.normals[rows], 1.5)
    assert before.shape == (len(rows), DESCRIPTOR_LENGTH)
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_each_place_is_among_the_most_like_itself_on_other_pieces(pieces):
    rows = np.arange(0, len(pieces), 10)
    before = describe(pieces, pieces.places[rows], pieces.normals[rows], 0.6)
    after = describe(make_surfels(*pebble(60), 0.061), pieces.places[rows], pieces.normals[rows], 0.6)
    unit = before.std(axis=0) + 1e-3
    distance = np.linalg.norm((before[:, None] - after[None]) / unit, axis=2)
    closer = (distance < np.diag(distance)[:, None]).mean(axis=1)
    # By chance the median would be a half.
    assert np.median(closer) < 0.02
    assert np.quantile(closer, 0.8) < 0.1


def test_the_shells_share_out_the_area_within_the_ball():
    step = 0.01
    grid = np.stack(np.meshgrid(*[np.arange(-1, 1, step) + step / 2] * 2), axis=-1).reshape(-1, 2)
    places = np.column_stack([grid, np.zeros(len(grid))])
    flat = Surfels(
        places=places, normals=np.tile([0.0, 0, 1], (len(grid), 1)), areas=np.full(len(grid), step**2)
    )
    values = describe(flat, np.zeros((1, 3)), np.array([[0.0, 0, 1]]), 0.5).reshape(SHELLS, -1)
    distance = np.linalg.norm(places, axis=1) / 0.5
    inside = distance < 1.0
    for shell in some(range(SHELLS)):
        weight = np.maximum(1.0 - np.abs(distance * (SHELLS + 0.5) - 0.5 - shell), 0.0) * inside
        ring = np.pi * 0.25 * (2.0 * shell + 1.5) / (SHELLS + 0.5) ** 2
        assert values[shell, 0] == pytest.approx(weight.sum() * step**2 / ring)
    np.testing.assert_allclose(values[:, 1:3], 0.0, atol=1e-12)  # no height on a plane
    np.testing.assert_allclose(values[:, 3], values[:, 0])  # all normals alike
    np.testing.assert_allclose(values[1:, 5:], 0.0, atol=0.03)  # no direction stands out


def test_tangent_axes_complete_right_handed_triples():
    normals = np.random.default_rng(0).normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    first, second = tangent_axes(normals)
    triples = np.stack([first, second, normals], axis=1)
    np.testing.assert_allclose(
        triples @ triples.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(triples), 1.0)

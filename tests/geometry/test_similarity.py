from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshmark.errors import InputError
from meshmark.geometry.similarity import Similarity, fit_similarity, rotation_of
from tests.counting import some


def planted(seed: int) -> Similarity:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    return Similarity(scale=float(rng.uniform(0.1, 10.0)), rotation=turn, shift=5.0 * rng.normal(size=3))


def test_a_planted_similarity_comes_back():
    points = np.random.default_rng(0).normal(size=(20, 3))
    for seed in range(10):
        true = planted(seed)
        found = fit_similarity(points, true(points))
        np.testing.assert_allclose(found.scale, true.scale, rtol=1e-12)
        np.testing.assert_allclose(found.rotation, true.rotation, atol=1e-12)
        np.testing.assert_allclose(found.shift, true.shift, atol=1e-11)


def test_points_without_weight_do_not_matter():
    points = np.random.default_rng(1).normal(size=(20, 3))
    true = planted(3)
    target = true(points)
    target[:5] += 100.0
    weights = np.r_[np.zeros(5), np.random.default_rng(2).uniform(0.1, 1.0, 15)]
    np.testing.assert_allclose(fit_similarity(points, target, weights)(points), true(points), atol=1e-10)


def test_the_fit_is_the_least_squares_one():
    rng = np.random.default_rng(4)
    points, target = rng.normal(size=(2, 12, 3))
    best = fit_similarity(points, target)
    error = np.square(best(points) - target).sum()
    for _ in range(200):
        turn = Rotation.from_rotvec(1e-3 * rng.normal(size=3)).as_matrix()
        other = Similarity(
            scale=1.0 + 1e-3 * rng.normal(), rotation=turn, shift=1e-3 * rng.normal(size=3)
        ).after(best)
        assert np.square(other(points) - target).sum() >= error


def test_a_mirror_image_gets_a_proper_rotation():
    points = np.random.default_rng(5).normal(size=(20, 3))
    assert np.linalg.det(fit_similarity(points, points * [1, 1, -1]).rotation) == pytest.approx(1.0)


def test_points_that_are_one_point_are_refused():
    with pytest.raises(InputError, match="all one point"):
        fit_similarity(np.ones((4, 3)), np.zeros((4, 3)))


def test_composition_and_inverse():
    one, other = planted(6), planted(7)
    points = np.random.default_rng(8).normal(size=(9, 3))
    np.testing.assert_allclose(one.after(other)(points), one(other(points)), atol=1e-11)
    np.testing.assert_allclose(one.inverse()(one(points)), points, atol=1e-12)
    np.testing.assert_array_equal(Similarity.identity()(points), points)
    step = one(points[:1]) - one(points[1:2])
    np.testing.assert_allclose(step, one.scale * one.turn(points[:1] - points[1:2]), atol=1e-11)


def test_rotation_of_a_vector_is_scipys():
    for vector in some(np.random.default_rng(9).normal(size=(10, 3))):
        np.testing.assert_allclose(rotation_of(vector), Rotation.from_rotvec(vector).as_matrix(), atol=1e-14)
    np.testing.assert_array_equal(rotation_of(np.zeros(3)), np.eye(3))

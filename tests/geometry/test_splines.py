from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.splines import spline_weights


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(3).normal(size=(200, 3)) * [1.0, 4.0, 0.2]


def test_values_are_shares_of_27_splines(points):
    weights = spline_weights(points, 0.3)
    assert (np.diff(weights.indptr) == 27).all()
    assert (weights.data >= 0.0).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-14)
    assert (weights.sum(axis=0) > 0.0).all()


def test_one_axis_is_the_quadratic_b_spline(points):
    from scipy.interpolate import BSpline

    pitch = 0.3
    weights = spline_weights(points, pitch).toarray()
    home = np.round(points[0] / pitch)  # the spline whose middle is nearest to the first point
    value = np.prod(
        [
            BSpline.basis_element(np.arange(-1.5, 2.0), extrapolate=False)(points[:, i] / pitch - home[i])
            for i in range(3)
        ],
        axis=0,
    )
    value = np.nan_to_num(value)
    assert value[0] > 0.125
    distance = np.abs(weights - value[:, None]).max(axis=0)
    assert distance.min() < 1e-14


def test_planes_are_sums_of_splines(points):
    weights = spline_weights(points, 0.3)
    fitted = weights @ np.linalg.lstsq(weights.toarray(), points, rcond=None)[0]
    np.testing.assert_allclose(fitted, points, atol=1e-12)


def test_points_further_apart_than_two_knots_share_nothing():
    weights = spline_weights(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), 0.3)
    assert (weights @ weights.T).toarray()[0, 1] == 0.0

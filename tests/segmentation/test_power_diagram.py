from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import cKDTree

from meshmark.segmentation.power_diagram import assign, balanced_weights

RNG = np.random.default_rng(11)


def test_without_weights_every_point_goes_to_the_nearest_seed() -> None:
    points, seeds = RNG.normal(size=(2000, 3)), RNG.normal(size=(9, 3))
    np.testing.assert_array_equal(assign(points, seeds, np.zeros(9)), cKDTree(seeds).query(points)[1])


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("count", [3000, 40_000])
def test_masses_are_shared_equally_at_any_size(size: float, count: int) -> None:
    points = RNG.random((count, 3)) * [5.0, 1.0, 0.2] * size
    masses = RNG.random(count)
    seeds = points[:12]
    cells = assign(points, seeds, balanced_weights(points, masses, seeds))
    held = np.bincount(cells, weights=masses, minlength=12) / masses.sum()
    assert held.max() * 12 <= 1.0 + 12 * 2.0 / count + 0.002


def test_the_plan_costs_what_the_linear_programme_says() -> None:
    count, cells = 300, 5
    points, seeds = RNG.random((count, 3)), RNG.random((cells, 3))
    masses = np.full(count, 1.0 / count)
    cost = ((points[:, None] - seeds) ** 2).sum(axis=2)
    each_point = np.kron(np.eye(count), np.ones(cells))
    each_cell = np.kron(np.ones(count), np.eye(cells))
    target = np.concatenate([masses, np.full(cells, 1.0 / cells)])
    exact = linprog(cost.ravel(), A_eq=np.concatenate([each_point, each_cell]), b_eq=target).fun
    found = assign(points, seeds, balanced_weights(points, masses, seeds))
    assert masses @ cost[np.arange(count), found] == pytest.approx(exact, rel=0.01)


def test_one_seed_and_one_place_are_no_trouble() -> None:
    points = np.zeros((5, 3))
    assert not assign(points, points[:1], balanced_weights(points, np.ones(5), points[:1])).any()
    assert np.isfinite(balanced_weights(points, np.ones(5), points[:2])).all()


def test_points_in_about_one_place_cannot_be_shared_out() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1e-180]])
    seeds = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    assert balanced_weights(points, np.ones(2), seeds).tolist() == [0.0, 0.0]

"""A lock grown from a cluster finds planted corrections far beyond what a plain search holds."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.carriers import grown_lock as growing
from meshmark.ownership.carriers.grown_lock import FIRST, grown, neighbourhood
from meshmark.ownership.carriers.lock import LockSearch
from meshmark.ownership.carriers.lock_grid import grid_size
from tests.counting import Share

EXPECTED = np.array([0.014] * 3 + [0.011] + [0.016] * 3)
STEP = 0.018  # 0.1 spacings of 0.18


def problem(seed, size, noise=0.3, cells=220):
    """Cells on an ellipsoid, their response to a pose, and phases a planted correction brings to 0."""
    rng = np.random.default_rng(seed)
    ball = rng.normal(size=(cells, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    axes = np.array([1.5, 1.0, 0.6])
    place, normal = ball * axes, ball / axes
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    along = np.einsum("ij,ij->i", normal, place)
    gradient = 4.0 * np.pi / STEP * np.column_stack([normal, along, np.cross(place, normal)])
    truth = rng.normal(size=7)
    truth *= size / np.linalg.norm(truth) * EXPECTED
    return -gradient @ truth + noise * rng.normal(size=cells), gradient, place, truth


@pytest.mark.parametrize("seed", range(6))
def test_planted_corrections_are_found(seed):
    psi, gradient, place, truth = problem(seed, size=2.0)
    order = neighbourhood(gradient * EXPECTED, place, np.ones(len(place)))
    best = grown(psi, gradient, EXPECTED, order, weight=np.ones(len(psi)))
    assert best is not None
    np.testing.assert_allclose(best.correction, truth, atol=1e-3)
    assert best.score == pytest.approx(np.cos(psi + gradient @ truth).sum(), rel=0.05)


def test_cells_of_little_weight_do_no_harm():
    """A correction is found by the half of the cells that counts, the phases of the others being anything."""
    found = 0
    for seed in range(8):
        rng = np.random.default_rng(50 + seed)
        psi, gradient, place, truth = problem(seed, size=1.2, cells=440)
        lost = rng.random(len(psi)) < 0.5
        psi = np.where(lost, rng.uniform(0.0, 2.0 * np.pi, len(psi)), psi)
        weight = np.where(lost, 0.1, 1.0)
        weight /= np.sqrt(np.mean(weight**2))
        order = neighbourhood(gradient * EXPECTED * weight[:, None], place, weight)
        lock = grown(psi, gradient, EXPECTED, order, weight=weight)
        found += lock is not None and bool(np.abs(lock.correction - truth).max() < 3e-3)
    assert found >= 7


def test_a_plain_search_of_as_many_corrections_misses_them():
    """What growing is for: all cells at once leave a grid of so many points far too small a ball."""
    found = 0
    for seed in range(6):
        psi, gradient, _, truth = problem(seed, size=2.0)
        search = LockSearch(psi, gradient, EXPECTED, 2.5, 400_000, weight=np.ones(len(psi)))
        (best,) = search.polished(search.rough(1))
        found += bool(np.abs(best.correction - truth).max() < 2e-3)
    assert found <= 2


def test_chance_does_not_lock_by_its_own_bound(monkeypatch):
    """Clusters that stand out less are followed, too: else chance hardly ever gets as far as a lock."""
    monkeypatch.setattr(growing, "STANDS_OUT", 4.5)
    with Share(0.5) as share:
        for seed in range(10):
            rng = np.random.default_rng(100 + seed)
            _, gradient, place, _ = problem(seed, size=1.0)
            psi = rng.uniform(0.0, 2.0 * np.pi, len(gradient))
            order = neighbourhood(gradient * EXPECTED, place, np.ones(len(place)))
            share.case()
            lock = grown(psi, gradient, EXPECTED, order, weight=np.ones(len(psi)))
            if lock is not None:
                share.asserted()
                assert -(lock.score**2) / len(psi) / np.log(10.0) + np.log10(lock.tried) > 0.0


def test_the_first_cluster_is_near_and_takes_few_corrections():
    _, gradient, place, _ = problem(1, size=1.0)
    order = neighbourhood(gradient * EXPECTED, place, np.ones(len(place)))
    assert sorted(order) == list(range(len(place)))
    distance = np.linalg.norm(place[order] - place[order[0]], axis=1)
    assert (np.diff(distance) >= 0.0).all()
    sizes = [
        grid_size((gradient * EXPECTED)[np.argsort(np.linalg.norm(place - centre, axis=1))[:FIRST]], 2.5)
        for centre in place
    ]
    assert grid_size((gradient * EXPECTED)[order[:FIRST]], 2.5) <= np.quantile(sizes, 0.1)


def test_few_cells_are_one_cluster():
    _, gradient, place, _ = problem(1, size=1.0, cells=30)
    order = neighbourhood(gradient * EXPECTED, place, np.ones(len(place)))
    assert sorted(order) == list(range(30))


def test_a_wider_ball_holds_more():
    _, gradient, _, _ = problem(1, size=1.0)
    assert grid_size(gradient * EXPECTED, 1.0) < grid_size(gradient * EXPECTED, 2.0)
    assert grid_size(gradient[:, :0], 1.0) == 1.0


def test_the_first_cluster_is_of_the_cells_of_most_weight():
    """Where the others lie changes nothing but the order in which they are held."""
    _, gradient, place, _ = problem(1, size=1.0, cells=880)
    weight = np.where(np.arange(len(place)) % 2 == 0, 1.3, 0.5)
    order = neighbourhood(gradient * EXPECTED, place, weight)
    heavy = order[weight[order] > 1.0][:FIRST]
    alone = np.flatnonzero(weight > 1.0)
    sizes = [
        grid_size(
            (gradient * EXPECTED)[alone[np.argsort(np.linalg.norm(place[alone] - centre, axis=1))[:FIRST]]],
            2.5,
        )
        for centre in place
    ]
    assert grid_size((gradient * EXPECTED)[heavy], 2.5) <= np.quantile(sizes, 0.1)

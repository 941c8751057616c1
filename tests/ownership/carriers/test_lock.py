"""The lock finds planted corrections, agrees with plain search, and bounds chance honestly."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.carriers import lock_grid as module
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.lock import LockSearch, StepSearch
from meshmark.ownership.carriers.quantisation import log10_lock_chance

EXPECTED = np.array([0.005] * 4 + [0.006] * 3)


def search_lock(psi, gradient, expected, radius=2.2, weight=None):
    weight = np.ones(len(psi)) if weight is None else weight
    search = LockSearch(psi, gradient, expected, radius, weight=weight)
    return sorted(search.polished(search.rough(3)), key=lambda lock: -lock.score)


def problem(seed, cells=250, noise=0.3, size=2.0):
    """Phases a planted correction brings to 0, up to noise; the response of typical cells at a step of 0.02."""
    rng = np.random.default_rng(seed)
    gradient = 2.0 * np.pi / 0.01 * rng.normal(size=(cells, 7)) * 0.58
    truth = rng.normal(size=7)
    truth *= size / np.linalg.norm(truth) * EXPECTED
    return -gradient @ truth + noise * rng.normal(size=cells), gradient, truth


@pytest.mark.parametrize("seed", range(8))
def test_planted_corrections_are_found(seed):
    psi, gradient, truth = problem(seed)
    best = search_lock(psi, gradient, EXPECTED, radius=2.2)[0]
    np.testing.assert_allclose(best.correction, truth, atol=2e-4)
    assert best.score == pytest.approx(np.cos(psi + gradient @ truth).sum(), rel=0.05)


def test_the_grid_search_is_the_plain_search():
    """All sums of two halves, one matrix product, against every grid point in turn."""
    psi, gradient, _ = problem(3, cells=40)
    response = gradient * EXPECTED
    weight = np.random.default_rng(4).uniform(0.2, 1.8, 40)
    grid = module.plan_grid(response, weight, 1.5, module.MOST)
    one, two = grid.halves
    sums = [
        (p + q, a * a + b * b)
        for p, a in zip(one.places, one.distances, strict=True)
        for q, b in zip(two.places, two.distances, strict=True)
        if a * a + b * b <= grid.radius**2 * (1 + module.ROUNDING)
    ]
    assert len(sums) == grid.size > 100
    worth = [weight @ np.cos(psi + response @ place) - far for place, far in sums]
    best = module.best_places(grid, psi, weight, 1)[0]
    np.testing.assert_allclose(best, sums[int(np.argmax(worth))][0], atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_cells_of_no_weight_say_nothing(seed):
    """Half of the cells, of no weight, may show any phases: correction and score are those of the others."""
    psi, gradient, truth = problem(seed, cells=500)
    rng = np.random.default_rng(100 + seed)
    lost = rng.random(500) < 0.5
    psi = np.where(lost, rng.uniform(0.0, 2.0 * np.pi, 500), psi)
    with_all = search_lock(psi, gradient, EXPECTED, weight=np.where(lost, 0.0, 1.0))[0]
    np.testing.assert_allclose(with_all.correction, truth, atol=2e-4)
    without = search_lock(psi[~lost], gradient[~lost], EXPECTED)[0]
    assert with_all.score == pytest.approx(without.score, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_all_steps_at_once_find_what_each_step_finds(seed):
    rng = np.random.default_rng(seed)
    psi, gradient, _ = problem(seed)
    steps = (2.0, 1.0, 0.5)
    phases = np.stack([rng.uniform(0.0, 2.0 * np.pi, len(psi)), psi, rng.uniform(0.0, 2.0 * np.pi, len(psi))])
    weight = rng.uniform(0.5, 1.5, len(psi))
    together = StepSearch(phases, gradient, steps, EXPECTED, 2.0, weight=weight)
    alone = [
        LockSearch(each, gradient / step, EXPECTED, 2.0, weight=weight)
        for each, step in zip(phases, steps, strict=True)
    ]
    assert together.tried == pytest.approx(sum(search.tried for search in alone))
    wanted = [
        (lock.score, step)
        for step, one in zip(steps, alone, strict=True)
        for lock in one.polished(one.rough(4))
    ]
    found = [(lock.score, step) for step, lock in together.best(4, 12)]
    assert found == sorted(found, reverse=True)
    np.testing.assert_allclose(sorted(found), sorted(wanted), rtol=1e-9)
    assert together.best(4, 3)[0][0] == 1.0
    assert together.best(4, 3)[0][1].score == pytest.approx(found[0][0])


def test_a_small_correction_is_climbed_to_from_rest():
    psi, gradient, truth = problem(5, size=0.1)
    search = LockSearch(psi, gradient, EXPECTED, 2.2, weight=np.ones(len(psi)))
    rest = search.at_rest()
    np.testing.assert_array_equal(rest.correction, np.zeros(7))
    assert rest.score == pytest.approx(np.cos(psi).sum())
    (top,) = search.polished([rest])
    np.testing.assert_allclose(top.correction, truth, atol=2e-4)
    assert top.score > rest.score


def test_a_correction_of_nothing_is_kept():
    psi, gradient, _ = problem(1, noise=0.1, size=0.0)
    best = search_lock(psi, gradient, EXPECTED)[0]
    assert np.abs(best.correction).max() < 1e-4


def test_ill_determined_directions_do_no_harm():
    psi, gradient, truth = problem(2)
    gradient = np.column_stack([gradient, 1e-9 * gradient[:, 0]])
    best = search_lock(psi, gradient, np.append(EXPECTED, 1.0))[0]
    np.testing.assert_allclose(best.correction[:7], truth, atol=2e-4)


def test_the_same_input_gives_the_same_answer():
    psi, gradient, _ = problem(5)
    first, second = (search_lock(psi, gradient, EXPECTED) for _ in range(2))
    assert [lock.score for lock in first] == [lock.score for lock in second]


@pytest.mark.parametrize("pilots", [0.0, 0.2])
def test_chance_is_bounded(pilots):
    """On random phases the bound, times the corrections tried, is rarely small: p-values at least uniform."""
    rng = np.random.default_rng(0)
    _, gradient, _ = problem(0, cells=200)
    keys = CellKeys(code_index=np.arange(200), dither=np.zeros(200), pilot=np.arange(200) < 200 * pilots)
    gradient = keys.factor[:, None] * gradient / 4.0
    bounds = []
    for _ in range(200):
        best = search_lock(rng.uniform(0, 2 * np.pi, 200), gradient, EXPECTED, weight=keys.weight)[0]
        bounds.append(log10_lock_chance(best.score, 200) + np.log10(best.tried))
    # Of 200 p-values at least as large as uniform, more than 8 below 0.01 come with a chance below 1e-4.
    assert (np.array(bounds) < -2.0).sum() <= 8

"""The bound on the chance of a lock of points."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.points.lock_chance import LOOSE, log10_lock_chance, log10_loose_chance


@pytest.mark.parametrize("sizes", [np.ones(10), np.array([3.0, 2.0, 2.0, 1.0, 1.0, 1.0, 0.5])])
def test_chance_goes_below_the_bound_no_more_often_than_it_says(sizes):
    random = np.random.default_rng(3)
    scores = np.cos(random.uniform(0.0, 2.0 * np.pi, (20_000, len(sizes)))) @ sizes
    bounds = np.array([log10_lock_chance(score, sizes) for score in np.sort(scores)[-1000:]])
    for limit in (-1.5, -2.0, -3.0):
        assert (bounds <= limit).sum() <= 20_000 * 10.0**limit
    assert bounds.min() < -2.0


def test_it_counts_how_exact_the_phases_are():
    def bound(deviation: float) -> float:
        return log10_lock_chance(12.0 * np.exp(-(deviation**2) / 2.0), np.ones(12))

    assert bound(0.01) < bound(0.1) < bound(0.5) < bound(1.0) < 0.0
    assert bound(0.01) < -20.0
    # Never above the bound that counts the score alone, but for the exponents that are not tried.
    assert bound(0.5) < -12.0 * np.exp(-0.25) / np.log(10.0)


@pytest.mark.parametrize(("score", "sizes"), [(0.0, np.ones(3)), (-1.0, np.ones(3)), (0.0, np.zeros(0))])
def test_what_does_not_lock_is_chance(score, sizes):
    assert log10_lock_chance(score, sizes) == 0.0


@pytest.mark.parametrize("length", [0.55, 0.8, 0.9, 0.99, 0.999999])
def test_one_of_the_exponents_that_are_tried_is_nearly_the_best(length):
    from scipy.special import i0e

    exponents = np.geomspace(1e-2, 1e8, 2000)
    best = float((200 * (np.log(i0e(exponents)) + exponents) - exponents * 200 * length).min()) / np.log(10.0)
    told = log10_lock_chance(200 * length, np.ones(200))
    assert 1.001 * best <= told < 0.98 * best
    assert told < log10_loose_chance(200 * length, 200.0) < 0.0


def test_where_the_phases_are_far_off_it_is_the_loose_bound():
    score, sizes = (LOOSE - 0.01) * 300.0, np.ones(300)
    assert log10_lock_chance(score, sizes) == log10_loose_chance(score, 300.0)


def test_a_point_that_was_not_set_makes_the_loose_bound_the_better_one_to_compare_by():
    """A share of a mark that happens to hold exact points alone is less likely by the closer bound."""
    exact, off = 60.0, 20
    part, whole = log10_lock_chance(exact, np.ones(60)), log10_lock_chance(exact * 4, np.ones(240 + off))
    assert part < whole
    assert log10_loose_chance(exact, 60.0) > log10_loose_chance(exact * 4, 240.0 + off)

"""The bound on the chance of a lock of a handful of coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.points.few_points import log10_lock_chance_of_few


@pytest.mark.parametrize("sizes", [np.ones(10), np.array([3.0, 2.0, 2.0, 1.0, 1.0, 1.0, 0.5])])
def test_chance_goes_below_the_bound_no_more_often_than_it_says(sizes):
    random = np.random.default_rng(3)
    scores = np.cos(random.uniform(0.0, 2.0 * np.pi, (20_000, len(sizes)))) @ sizes
    bounds = np.array([log10_lock_chance_of_few(score, sizes) for score in np.sort(scores)[-1000:]])
    for limit in (-1.5, -2.0, -3.0):
        assert (bounds <= limit).sum() <= 20_000 * 10.0**limit
    assert bounds.min() < -2.0


def test_it_counts_how_exact_the_phases_are():
    def bound(deviation: float) -> float:
        return log10_lock_chance_of_few(12.0 * np.exp(-(deviation**2) / 2.0), np.ones(12))

    assert bound(0.01) < bound(0.1) < bound(0.5) < bound(1.0) < 0.0
    assert bound(0.01) < -20.0
    # Never above the bound that counts the score alone, but for the exponents that are not tried.
    assert bound(0.5) < -12.0 * np.exp(-0.25) / np.log(10.0)


@pytest.mark.parametrize(("score", "sizes"), [(0.0, np.ones(3)), (-1.0, np.ones(3)), (0.0, np.zeros(0))])
def test_what_does_not_lock_is_chance(score, sizes):
    assert log10_lock_chance_of_few(score, sizes) == 0.0

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from meshmark.research.benchmark.figures.intervals import mean, per_model, rate, rate_by_model, upper_limit


@pytest.mark.parametrize(("hits", "trials"), [(0, 1), (1, 1), (0, 30), (30, 30), (7, 31), (999, 1000)])
def test_rates_have_the_exact_interval_of_scipy(hits, trials):
    expected = binomtest(hits, trials).proportion_ci(0.95, "exact")
    found = rate(hits, trials)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-9)
    assert (found.value, found.count) == (hits / trials, trials)


@pytest.mark.parametrize("trials", [1, 20, 1000])
def test_without_a_hit_the_upper_limit_is_the_rule_of_three(trials):
    assert upper_limit(0, trials) == pytest.approx(1 - 0.05 ** (1 / trials))
    assert upper_limit(0, 1000) == pytest.approx(3 / 1000, rel=5e-3)
    one_sided = binomtest(trials // 2, trials, alternative="less").proportion_ci(0.95, "exact")
    assert upper_limit(trials // 2, trials) == pytest.approx(one_sided.high)


def test_nothing_measured_has_no_interval():
    assert rate(0, 0) is None
    assert mean([]) is None
    assert rate_by_model([], []) is None
    assert upper_limit(0, 0) == 1.0


@given(st.lists(st.booleans(), min_size=1, max_size=40))
def test_a_mean_of_zeros_and_ones_is_a_rate(hits):
    assert mean([float(hit) for hit in hits]) == rate(sum(hits), len(hits))


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_an_interval_of_a_mean_holds_it_and_stays_in_the_limits(values):
    found = mean(values)
    assert 0 <= found.low <= found.value <= found.high <= 1
    assert found.value == pytest.approx(math.fsum(values) / len(values), abs=1e-12)
    assert found == mean(values[::-1]), "neither order nor call changes it"


def test_limits_other_than_0_and_1_only_move_the_scale():
    values = [0.2, 0.7, 0.4, 0.9]
    plain, moved = mean(values), mean([2 * v - 1 for v in values], (-1.0, 1.0))
    for name in ("value", "low", "high"):
        assert getattr(moved, name) == pytest.approx(2 * getattr(plain, name) - 1)


def test_equal_errors_leave_room_for_what_was_not_seen():
    # All n values 0.01: the upper limit is 0.01 + 0.99 w, w the weight of one unseen 1, Beta(1, n).
    found = mean([0.01] * 20)
    assert found.high == pytest.approx(0.01 + 0.99 * (1 - 0.025 ** (1 / 20)), rel=0.03)


def test_intervals_hold_the_truth_at_least_as_often_as_they_say():
    rng = np.random.default_rng(5)
    truth = 0.2 * 0.3  # a fifth of the models have errors, 30 % on average
    held = 0
    for _ in range(400):
        values = np.where(rng.random(25) < 0.2, rng.uniform(0.1, 0.5, 25), 0.0)
        found = mean(values.tolist())
        held += found.low <= truth <= found.high
    assert held >= 0.95 * 400


def test_trials_on_one_model_count_once():
    hits = [True] * 10 + [False] * 10
    alike = rate_by_model(hits, ["a"] * 10 + ["b"] * 10)
    apart = rate_by_model(hits, [str(i) for i in range(20)])
    two, twenty = rate(1, 2), rate(10, 20)
    assert (alike.value, alike.low, alike.high) == (0.5, two.low, two.high)
    assert (apart.value, apart.low, apart.high) == (0.5, twenty.low, twenty.high)


def test_the_mean_of_a_model_is_of_its_own_values():
    assert per_model([1.0, 2.0, 6.0], ["b", "a", "b"]) == [2.0, 3.5]

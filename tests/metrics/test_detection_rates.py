"""Rates and thresholds: the threshold keeps the rate that was asked for, and is the lowest that does."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.metrics.detection_rates import detection_rate, present_rate, threshold_for
from tests.counting import Share

SCORES = st.lists(st.integers(-5, 5).map(float), min_size=1, max_size=50)


def test_the_threshold_keeps_the_rate_and_no_lower_one_does():
    with Share(0.3) as share:
        keeps_the_rate(share)


@given(SCORES, st.floats(0.0, 1.0))
def keeps_the_rate(share, scores, rate):
    threshold = threshold_for(scores, rate)
    assert present_rate(scores, threshold) <= rate * (1 + 1e-9)
    lower = [score for score in scores if score < threshold]
    share.case()
    if lower:
        share.asserted()
        assert present_rate(scores, max(lower)) > rate * (1 - 1e-9)


@pytest.mark.parametrize(("rate", "threshold"), [(0.0, 10.0), (0.1, 9.0), (0.25, 8.0), (1.0, -np.inf)])
def test_planted_scores(rate, threshold):
    unmarked = np.arange(1.0, 11.0)
    found = threshold_for(unmarked, rate)
    assert found == (threshold if np.isinf(threshold) else np.nextafter(threshold, np.inf))
    assert detection_rate([8.0, 9.0, 9.5, 20.0], unmarked, rate) == np.mean(
        np.array([8.0, 9.0, 9.5, 20.0]) > threshold
    )


def test_a_score_at_the_threshold_is_present():
    assert present_rate([1.0, 2.0, 3.0, 4.0], 3.0) == 0.5


@pytest.mark.parametrize("scores", [[], [np.nan], [[1.0]]])
def test_no_scores_are_refused(scores):
    with pytest.raises(InputError, match="scores"):
        present_rate(scores, 0.0)


@pytest.mark.parametrize("rate", [-0.1, 1.1, np.nan])
def test_impossible_rates_are_refused(rate):
    with pytest.raises(InputError, match="rate"):
        threshold_for([1.0], rate)

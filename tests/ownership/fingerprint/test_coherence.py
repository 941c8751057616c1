"""Phases that agree place by place are told from those of chance, whatever the frame."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.fingerprint.coherence import coherence

RANDOM = np.random.default_rng(4)
COUNT = 1200
PLACES = RANDOM.uniform(-1.0, 1.0, (COUNT, 3))
AXIS = RANDOM.integers(0, 3, COUNT)
ALONE = np.arange(COUNT)


@pytest.mark.parametrize("turn", [0.0, 2.0, 4.0])
def test_a_turn_by_which_the_whole_does_not_agree_does_not_hide_it(turn):
    noise = 0.8 * RANDOM.normal(size=COUNT)
    phase = turn * PLACES[np.arange(COUNT), (AXIS + 1) % 3] + noise
    assert coherence(PLACES, AXIS, phase, ALONE) > 10.0
    assert (np.cos(phase).mean() > 0.4) == (turn == 0.0)


def test_phases_of_chance_agree_by_chance():
    found = [coherence(PLACES, AXIS, RANDOM.uniform(0.0, 6.3, COUNT), ALONE) for _ in range(200)]
    assert abs(np.mean(found)) < 1.0  # the better one of two sizes of boxes
    assert np.std(found) == pytest.approx(1.0, abs=0.3)
    assert max(found) < 4.5


def test_coordinates_that_share_what_the_key_says_are_one_and_each_axis_is_for_itself():
    shared = np.arange(COUNT) // 6
    places = PLACES[6 * shared]
    phase = RANDOM.uniform(0.0, 6.3, COUNT)[6 * shared]
    axis = np.zeros(COUNT, dtype=int)
    assert coherence(places, axis, phase, ALONE) > 10.0
    assert abs(coherence(places, axis, phase, shared)) < 4.5
    each = RANDOM.uniform(0.0, 6.3, 3)
    assert coherence(PLACES, AXIS, each[AXIS], ALONE) > 10.0


def test_where_no_box_has_two_nothing_is_said():
    assert coherence(PLACES[:1], AXIS[:1], np.zeros(1), ALONE[:1]) == 0.0

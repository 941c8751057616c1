"""Precision, recall and IoU of vertex maps, against sets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.metrics.tamper import iou, precision, recall


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=60))
def test_as_sets_say(pairs):
    altered, found = (np.array(column) for column in zip(*pairs, strict=True))
    truth, claim = set(np.flatnonzero(altered)), set(np.flatnonzero(found))
    assert precision(altered, found) == (len(truth & claim) / len(claim) if claim else 1.0)
    assert recall(altered, found) == (len(truth & claim) / len(truth) if truth else 1.0)
    assert iou(altered, found) == (len(truth & claim) / len(truth | claim) if truth | claim else 1.0)


def test_when_nothing_was_altered_a_false_alarm_shows_in_precision_and_iou():
    none, one = np.zeros(5, bool), np.arange(5) == 2
    assert (precision(none, none), recall(none, none), iou(none, none)) == (1.0, 1.0, 1.0)
    assert (precision(none, one), recall(none, one), iou(none, one)) == (0.0, 1.0, 0.0)
    assert (precision(one, none), recall(one, none), iou(one, none)) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("pair", [([0, 1], [1, 1]), ([True], [True, False]), ([[True]], [[True]])])
def test_what_is_no_map_is_refused(pair):
    for measure in (precision, recall, iou):
        with pytest.raises(InputError, match="bool"):
            measure(*pair)

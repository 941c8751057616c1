"""What strangers are told in words says no more than the bands beside it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from meshmark.ownership.answer import _in_words
from meshmark.ownership.decoding import Found
from tests.counting import some

CARRIERS = 100


@pytest.mark.parametrize("ids", [(1,), (1, 2), ()])
def test_the_advice_does_not_change_with_each_place_that_is_lost(ids):
    reading = SimpleNamespace(phase=np.zeros(CARRIERS), mirrored=False)
    found = Found(reading=reading, present=True, ids=ids, log10_false_positive=-40.0)  # type: ignore[arg-type]
    said = [_in_words(found, "blind", agreeing)[1] for agreeing in range(50, CARRIERS + 1)]
    assert len(set(said)) <= 2
    assert not any(str(agreeing) in text for agreeing, text in some(enumerate(said, start=50)))

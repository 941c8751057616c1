"""Bit error rate and correlation of payloads."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.metrics.bits import ber, correlation, recovered

PAYLOADS = st.lists(st.integers(0, 1), min_size=1, max_size=80).map(np.array)


@given(PAYLOADS, st.data())
def test_planted_errors(bits, data):
    wrong = data.draw(st.sets(st.integers(0, len(bits) - 1)))
    read = bits.copy()
    read[list(wrong)] ^= 1
    assert ber(bits, read) == len(wrong) / len(bits)
    assert recovered(bits, read) == float(not wrong)
    spread = bits.std() * read.std()
    expected = np.corrcoef(bits, read)[0, 1] if spread else float(not wrong)
    assert correlation(bits, read) == pytest.approx(expected, abs=1e-12)
    assert correlation(bits, bits) == 1.0


def test_the_opposite_and_chance():
    bits = np.random.default_rng(0).integers(0, 2, 100_000)
    assert (ber(bits, 1 - bits), correlation(bits, 1 - bits)) == (1.0, pytest.approx(-1.0))
    other = np.random.default_rng(1).integers(0, 2, 100_000)
    assert ber(bits, other) == pytest.approx(0.5, abs=0.01)
    assert correlation(bits, other) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("pair", [([], []), ([0, 1], [0]), ([0, 2], [0, 1]), ([[0]], [[0]]), ([0.5], [1])])
def test_what_is_no_payload_is_refused(pair):
    for measure in (ber, correlation, recovered):
        with pytest.raises(InputError):
            measure(*pair)

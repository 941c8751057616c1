from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.recovery.range_coder import Decoder, Encoder, Model

FIRST = [1, 5, 1, 1, 30]


@given(st.lists(st.integers(0, 4), max_size=300))
def test_the_range_coder_gives_symbols_and_bits_back(symbols):
    out, model = Encoder(), Model(FIRST)
    for symbol in symbols:
        out.symbol(model, symbol)
        out.bits(symbol * 1000, 13)
    read, model = Decoder(out.finish()), Model(FIRST)
    assert [(read.symbol(model), read.bits(13)) for _ in symbols] == [(s, s * 1000) for s in symbols]


@pytest.mark.parametrize("symbol", range(5))
def test_a_long_run_of_one_symbol_comes_back_and_costs_next_to_nothing(symbol):
    """The counts pass the limit where they are halved; always the last symbol makes carries run far back."""
    out, model = Encoder(), Model(FIRST)
    for _ in range(4000):
        out.symbol(model, symbol)
    content = out.finish()
    assert len(content) < 60
    read, model = Decoder(content), Model(FIRST)
    assert {read.symbol(model) for _ in range(4000)} == {symbol}
    assert not read.exhausted


@pytest.mark.parametrize("count", range(1, 17))
def test_plain_bits_of_every_width_come_back_and_cost_what_they_are(count):
    values = [*np.random.default_rng(count).integers(0, 1 << count, 500).tolist(), 0, (1 << count) - 1]
    out = Encoder()
    for value in values:
        out.bits(value, count)
    content = out.finish()
    assert len(content) <= len(values) * count / 8 + 4
    read = Decoder(content)
    assert [read.bits(count) for _ in values] == values


def test_the_range_coder_is_near_the_entropy():
    rng = np.random.default_rng(2)
    symbols = rng.choice(4, size=4000, p=[0.9, 0.06, 0.03, 0.01])
    out, model = Encoder(), Model([1, 1, 1, 1])
    for symbol in symbols:
        out.symbol(model, int(symbol))
    share = np.bincount(symbols, minlength=4) / len(symbols)
    assert 8 * len(out.finish()) < 1.04 * len(symbols) * -(share @ np.log2(share))


def test_zeros_at_the_end_are_not_written_but_read():
    out = Encoder()
    for _ in range(1000):
        out.bits(0, 8)
    content = out.finish()
    assert content == b""
    read = Decoder(content)
    assert [read.bits(8) for _ in range(10)] == [0] * 10


def test_reading_far_beyond_the_end_is_told():
    out = Encoder()
    for value in range(200):
        out.bits(value, 8)
    read = Decoder(out.finish()[:100])
    told = []
    for _ in range(200):
        read.bits(8)
        told.append(read.exhausted)
    assert told == sorted(told), "once exhausted, always"
    assert 96 <= told.index(True) <= 116


def test_a_model_learns_and_forgets_in_proportion():
    model = Model([1, 1])
    for _ in range(2000):
        model.learn(0)
        model.learn(1)
        model.learn(0)
    assert model.total == sum(model.counts) <= 2**14
    assert min(model.counts) > 0
    assert model.counts[0] / model.total == pytest.approx(2 / 3, abs=0.01)

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.coding.erasure import erasure_code, solver
from meshmark.coding.erasure.belief import trust
from meshmark.coding.erasure.erasure_code import ErasureCode, capacity, decode
from meshmark.coding.erasure.graph import DENSE, Graph, mix, sizes
from meshmark.coding.erasure.solver import eliminate, peel
from meshmark.errors import CapacityError, InputError
from tests.counting import some


def received(code: ErasureCode, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    index = np.random.default_rng(seed).integers(0, 1 << 32, count, dtype=np.uint32)
    return index, code(index)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.binary(max_size=150), st.integers(2, 16), st.integers(0, 1000))
def test_twice_what_is_needed_gives_the_message(message, bits, seed):
    code = ErasureCode(message, bits)
    index, value = received(code, 2 * code.size + 120, seed)
    assert decode(index, value, bits) == message


@pytest.mark.parametrize(("symbols", "bits"), [(200, 7), (330, 8), (330, 10), (1000, 9), (4000, 8)])
def test_what_capacity_says_is_read_back_from_so_many_symbols_in_any_order(symbols, bits):
    message = np.random.default_rng(1).bytes(capacity(symbols, bits))
    code = ErasureCode(message, bits)
    for seed in range(3):
        index, value = received(code, symbols, seed)
        order = np.random.default_rng(seed).permutation(symbols)
        assert decode(index[order], value[order], bits) == message


@pytest.mark.parametrize("symbols", [330, 1000, 12_000])
def test_capacity_is_most_of_what_the_symbols_hold(symbols):
    assert 8 * capacity(symbols, 8) > 0.8 * 8 * symbols
    assert 8 * capacity(symbols, 8) <= 8 * symbols


def test_capacity_never_falls_with_more_symbols():
    values = [capacity(symbols, 7) for symbols in range(0, 3000, 7)]
    assert values == sorted(values)
    assert values[0] == 0


@pytest.mark.parametrize("share", [0.01, 0.02])
@pytest.mark.parametrize("seed", range(3))
def test_some_wrong_symbols_do_no_harm(share, seed):
    message = np.random.default_rng(2).bytes(capacity(300, 8))
    index, value = received(ErasureCode(message, 8), 500, seed)
    rng = np.random.default_rng(100 + seed)
    wrong = rng.random(len(value)) < share
    value = np.where(wrong, value ^ rng.integers(1, 256, len(value)).astype(np.uint16), value)
    assert wrong.any()
    assert decode(index, value, 8) == message


def test_wrong_symbols_are_trusted_least():
    code = ErasureCode(bytes(range(100)), 8)
    graph = Graph(code.size)
    index = np.arange(400, dtype=np.uint32)
    intermediate = graph.intermediate(np.arange(code.size, dtype=np.uint16))
    value = graph.outputs(intermediate, index)
    wrong = np.array([30, 200, 350])
    value[wrong] ^= np.uint16(0x5A)
    odds = trust(graph, index, value, 8)
    assert set(np.argsort(odds)[:3]) == set(wrong)


@pytest.mark.parametrize("count", [0, 5, 90])
def test_too_few_symbols_give_nothing(count):
    code = ErasureCode(bytes(100), 8)
    assert decode(*received(code, count, 3), 8) is None


def test_noise_gives_nothing():
    rng = np.random.default_rng(4)
    index = rng.integers(0, 1 << 32, 400, dtype=np.uint32)
    assert decode(index, rng.integers(0, 256, 400).astype(np.uint16), 8) is None


def test_no_size_is_tried_that_hardly_any_pilot_names(monkeypatch):
    """Solving for noise takes far longer than for a message."""
    tried = []
    monkeypatch.setattr(erasure_code, "solve", lambda graph, *_: tried.append(graph.size))
    rng = np.random.default_rng(4)
    index = rng.integers(0, 1 << 32, 400, dtype=np.uint32)
    assert decode(index, rng.integers(0, 1 << 10, 400).astype(np.uint16), 10) is None
    assert tried == []
    code = ErasureCode(bytes(40), 10)
    value = code(index)
    wrong = rng.random(400) < 0.5
    decode(index, np.where(wrong, value ^ np.uint16(0x155), value), 10)
    assert tried == [code.size]


def test_symbols_have_so_many_bits_and_belong_to_their_index():
    code = ErasureCode(b"some bytes", 5)
    index, value = received(code, 5000, 5)
    assert value.max() == 31
    assert np.array_equal(code(index[::-1]), value[::-1])
    assert np.array_equal(ErasureCode(b"some bytes", 5)(index), value)
    assert not np.array_equal(ErasureCode(b"some bytez", 5)(index), value)


def test_intermediate_symbols_meet_their_parities():
    graph = Graph(2500)
    assert graph.segments == 3
    values = graph.intermediate(np.random.default_rng(6).integers(0, 256, 2500).astype(np.uint16))
    parity, symbol = graph.sparse_rows
    for row in some(values):
        sums = np.zeros(graph.sparse, np.uint16)
        np.bitwise_xor.at(sums, parity, row[symbol])
        assert not sums.any()
        assert not any(np.bitwise_xor.reduce(row[chosen]) for chosen in some(graph.dense_rows))
    assert values.shape == (3, graph.length + graph.sparse + DENSE)


def test_elimination_solves_what_is_planted_and_says_what_is_open():
    rng = np.random.default_rng(7)
    matrix = rng.integers(0, 2, (90, 70)).astype(np.uint8)
    planted = rng.integers(0, 1 << 16, 70).astype(np.uint16)
    right = np.array([np.bitwise_xor.reduce(planted[row == 1], initial=0) for row in matrix], np.uint16)
    rows = np.packbits(np.pad(matrix, ((0, 0), (0, 58))), axis=1, bitorder="little").view("<u8")
    assert np.array_equal(eliminate(rows, right, 70), planted)
    rows[:, 1] &= ~np.uint64(1)  # unknown 64 in no equation
    assert eliminate(rows, right, 70) is None


def test_peeling_finds_what_elimination_finds_or_nothing():
    graph = Graph(300)
    message = np.random.default_rng(5).integers(0, 256, 300).astype(np.uint16)
    whole = graph.intermediate(message)
    index = np.random.default_rng(6).integers(0, 1 << 32, 600, dtype=np.uint32)
    values = graph.outputs(whole, index)
    assert np.array_equal(peel(graph, index, values), whole[0])
    assert peel(graph, index[:200], values[:200]) is None


def test_mixing_is_the_known_splitmix64():
    # First outputs of splitmix64 for the seed 0, as published with the generator (Steele, Lea, Flood 2014).
    assert [hex(mix(np.array([i], np.uint32), 0)[0]) for i in range(2)] == [
        "0xe220a8397b1dcdaf",
        "0x6e789e6aa1b965f4",
    ]


def test_sizes_rise_to_the_largest_messages():
    assert (np.diff(sizes()) > 0).all()
    assert (np.diff(sizes()) / sizes()[:-1] <= 0.15).all()


def test_what_cannot_be_coded_is_refused():
    with pytest.raises(InputError, match="symbols of 17 bits"):
        ErasureCode(b"", 17)
    with pytest.raises(InputError, match="symbols of 0 bits"):
        capacity(100, 0)
    with pytest.raises(CapacityError, match="expected at most"):
        ErasureCode(bytes(10_000_000), 16)


def test_inputs_stay_as_they_are():
    code = ErasureCode(b"read-only", 8)
    index, value = received(code, 200, 8)
    index.flags.writeable = value.flags.writeable = False
    assert decode(index, value, 8) == b"read-only"


def test_symbols_that_come_often_count_once_and_their_wrong_copies_are_outvoted():
    message = np.random.default_rng(1).bytes(capacity(2000, 10))
    index, value = received(ErasureCode(message, 10), 2400, 5)
    index, value = np.repeat(index, 3), np.repeat(value, 3)
    value[:300:3] ^= 1  # one copy of three of each of the first hundred
    order = np.random.default_rng(6).permutation(len(index))
    assert decode(index[order], value[order], 10) == message


@pytest.mark.parametrize("seed", range(6))
def test_a_few_wrong_symbols_are_found_by_what_the_others_say(seed, monkeypatch):
    def called(*_: object) -> None:
        raise AssertionError("the few unknowns that a wrong symbol spoils need no belief propagation")

    monkeypatch.setattr(solver, "trust", called)
    random = np.random.default_rng(seed)
    message = random.bytes(1000)
    code = ErasureCode(message, 10)
    index = np.arange(1900, dtype=np.uint32) + np.uint32(seed * 5000)
    value = code(index).copy()
    wrong = random.choice(len(index), 2, replace=False)
    value[wrong] ^= random.integers(1, 1024, 2).astype(np.uint16)
    assert decode(index, value, 10) == message

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.coding.keyed import keyed_words
from meshmark.coding.polar import parity, polar_code, polar_transform, reliability_order
from meshmark.errors import InputError
from tests.counting import some

SUBKEY = bytes(range(32))
IDS = st.integers(0, 2**64 - 1)


def kernel_power(m: int) -> np.ndarray:
    """F^(x m) as Arikan defines it, by Kronecker products."""
    power = np.ones((1, 1), dtype=np.int64)
    for _ in range(m):
        power = np.kron(np.array([[1, 0], [1, 1]]), power)
    return power


@pytest.mark.parametrize("m", [0, 1, 2, 5, 8])
def test_the_transform_is_the_kronecker_power_and_its_own_inverse(m: int) -> None:
    u = np.random.default_rng(m).integers(0, 2, (7, 1 << m)).astype(np.uint8)
    assert np.array_equal(polar_transform(u), u @ kernel_power(m) % 2)
    assert np.array_equal(polar_transform(polar_transform(u)), u)


def test_the_transform_leaves_its_input_alone() -> None:
    u = np.ones(8, dtype=np.uint8)
    u.flags.writeable = False
    assert polar_transform(u).sum() == 1


def test_parity_counts_bits() -> None:
    sets = keyed_words(SUBKEY, 50)
    assert parity(sets).tolist() == [int(word).bit_count() % 2 for word in sets]


def test_the_reliability_order_respects_the_partial_order_of_polar_codes() -> None:
    """Adding a set bit, or moving one up, never makes a position worse (Schuerch 2016), for any channel."""
    rank = np.argsort(reliability_order(256))
    unset = [(i, b) for i in range(256) for b in range(8) if not i >> b & 1]
    movable = [(i, b) for i, b in unset if b and i >> (b - 1) & 1]
    for i, b in some(unset, least=1024):
        assert rank[i | 1 << b] > rank[i]
    for i, b in some(movable, least=448):
        assert rank[i ^ (3 << (b - 1))] > rank[i]


@given(IDS, IDS)
def test_the_code_is_linear(a: int, b: int) -> None:
    code = polar_code(256, 64, 8, SUBKEY)
    assert np.array_equal(code.encode(a) ^ code.encode(b), code.encode(a ^ b))
    assert not code.encode(0).any()


@given(IDS)
def test_encoding_is_the_generator_matrix(identity: int) -> None:
    """Built row by row from the definition: id bits alone at their positions, keyed sums after them."""
    code = polar_code(128, 64, 8, SUBKEY)
    words = [int(word) for word in keyed_words(SUBKEY, 128)]
    good = sorted(reliability_order(128)[-72:].tolist())[:64]
    u, earlier, bits = [], 0, iter(range(64))
    for i in range(128):
        if i in good:
            bit = next(bits)
            u.append(identity >> bit & 1)
            earlier |= 1 << bit
        else:
            u.append((identity & words[i] & earlier).bit_count() % 2)
    assert np.array_equal(code.encode(identity), np.array(u) @ kernel_power(7) % 2)


def test_no_word_is_light() -> None:
    """Ids that differ in one or two bits differ in many code bits; a plain polar code has weights of 1/16."""
    code = polar_code(4096, 64, 16, SUBKEY)
    singles = np.array([code.encode(1 << j) for j in range(64)])
    i, j = np.triu_indices(64, 1)
    weights = np.concatenate([singles.sum(axis=1), (singles[i] ^ singles[j]).sum(axis=1)])
    assert weights.min() > 0.15 * 4096


def test_every_code_bit_depends_on_the_key() -> None:
    codes = [polar_code(256, 64, 8, bytes([i]) * 32).encode(2**64 - 1) for i in range(64)]
    mean = np.mean(codes, axis=0)
    assert mean[:-1].min() > 0.1
    assert mean.max() < 0.9


@pytest.mark.parametrize(
    ("length", "bits", "checks"), [(100, 64, 8), (64, 64, 1), (256, 65, 0), (256, 0, 0), (256, 64, -1)]
)
def test_impossible_codes_are_refused(length: int, bits: int, checks: int) -> None:
    with pytest.raises(InputError):
        polar_code(length, bits, checks, SUBKEY)

from __future__ import annotations

import hashlib
from math import comb, log10

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.coding.codec import CHECK_WORD_LIMIT, Codec
from meshmark.coding.keyed_code import least_agreement, log10_chance
from meshmark.coding.keys import Key
from meshmark.coding.message import PRESENCE, short_id
from meshmark.errors import InputError
from tests.counting import some

KEY = Key(bytes(range(32)))
CODEC = Codec(KEY)
OTHER = Codec(Key(bytes(32)))
CODE_DIGEST = "a1d97940d9562a66f8f9f01964b9f2daba6d12d8cab4aa08095bcfc271034776"
FEWER_DIGEST = "46d6925aedcabce4318f87c22c0c5a1b7a580d1c43d8a2f250a1919484e3505f"
IDS = st.integers(0, 2**64 - 1)


def observe(identity: int, carriers: int, error: float, rng: np.random.Generator) -> np.ndarray:
    """Hard observations of random code bits, a share of them wrong."""
    index = rng.integers(0, CODEC.n, carriers)
    seen = 1.0 - 2.0 * (CODEC.encode(identity)[index] ^ (rng.random(carriers) < error))
    return np.bincount(index, seen, CODEC.n)


def average_of(
    one: int, other: int, carriers: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Observations of an average of two copies: which bit where they agree, a fair coin elsewhere; and where."""
    index = rng.integers(0, CODEC.n, carriers)
    bits, same = CODEC.encode(one)[index], CODEC.encode(one)[index] == CODEC.encode(other)[index]
    seen = np.where(same, 1.0 - 2.0 * bits, rng.choice([-1.0, 1.0], carriers))
    return np.bincount(index, seen, CODEC.n), np.bincount(index, np.where(same, 1.0, -1.0), CODEC.n)


@settings(max_examples=30)
@given(IDS, st.integers(120, 3000), st.integers(0, 2**32))
def test_an_id_comes_back_from_clean_carriers(identity: int, carriers: int, seed: int) -> None:
    decoded = CODEC.decode(observe(identity, carriers, 0.0, np.random.default_rng(seed)))
    assert decoded.id == identity
    assert decoded.log10_chance <= CHECK_WORD_LIMIT
    assert np.array_equal(decoded.bits, CODEC.encode(identity))
    assert 1 <= decoded.candidates_tested <= 64


@pytest.mark.parametrize(("carriers", "error"), [(150, 0.02), (300, 0.10), (1000, 0.25), (3000, 0.35)])
def test_an_id_comes_back_through_errors(carriers: int, error: float) -> None:
    rng = np.random.default_rng(carriers)
    ids = [int(rng.integers(2**63)) for _ in range(50)]
    found = [CODEC.decode(observe(identity, carriers, error, rng)).id for identity in ids]
    assert sum(a == b for a, b in zip(ids, found, strict=True)) >= 47
    assert all(b in (a, None) for a, b in zip(ids, found, strict=True))


def test_too_much_noise_gives_none_and_never_a_wrong_id() -> None:
    rng = np.random.default_rng(7)
    for carriers, error in [(70, 0.0), (150, 0.12), (400, 0.25), (1000, 0.34)]:
        for _ in range(50):
            identity = int(rng.integers(2**63))
            decoded = CODEC.decode(observe(identity, carriers, error, rng), log10_limit=-6.0)
            assert decoded.id in (None, identity)


def test_a_wrong_key_or_no_mark_never_passes() -> None:
    rng = np.random.default_rng(8)
    chances = []
    for trial in range(300):
        llr = observe(trial, int(rng.integers(60, 2000)), 0.0, rng)
        chances.append(OTHER.decode(llr).log10_chance)
        llr = rng.standard_normal(CODEC.n) * (rng.random(CODEC.n) < 0.1)
        chances.append(CODEC.decode(llr).log10_chance)
    assert min(chances) > -3.0


def test_nothing_observed_is_no_id() -> None:
    decoded = CODEC.decode(np.zeros(CODEC.n))
    assert decoded.id is None
    assert decoded.log10_chance == 0.0


@pytest.mark.parametrize("scale", [1e-9, 0.1, 1e9])
def test_the_scale_of_the_observations_does_not_matter(scale: float) -> None:
    llr = observe(99, 200, 0.05, np.random.default_rng(9))
    one, other = CODEC.decode(llr), CODEC.decode(scale * llr)
    assert one.id == other.id == 99
    assert one.log10_chance == pytest.approx(other.log10_chance, rel=1e-6)


def test_the_input_is_not_changed() -> None:
    llr = observe(99, 200, 0.05, np.random.default_rng(9))
    llr.flags.writeable = False
    assert CODEC.decode(llr).id == 99


def test_other_shapes_and_numbers_are_refused() -> None:
    for llr in (np.zeros(3), np.zeros((CODEC.n, 1)), np.full(CODEC.n, np.nan), np.full(CODEC.n, np.inf)):
        with pytest.raises(InputError, match="expected 4096 finite numbers"):
            CODEC.decode(llr)
    with pytest.raises(InputError, match="64-bit"):
        CODEC.encode(2**64)


def test_a_message_of_zeros_is_nothing_special() -> None:
    for identity in (0, 2**64 - 1):
        word = CODEC.encode(identity)
        assert abs(word.mean() - 0.5) < 0.04
        assert abs((word != OTHER.encode(identity)).mean() - 0.5) < 0.04


def test_both_ids_of_an_average_come_back() -> None:
    rng = np.random.default_rng(12)
    one, other = 0x0123456789ABCDEF, 0xFEDCBA9876543210
    alike, differ = average_of(one, other, 1200, rng)
    pair = CODEC.decode_pair(alike, differ)
    assert pair.ids == (one, other)
    assert max(pair.log10_chances) < CHECK_WORD_LIMIT
    assert CODEC.decode_pair(9.0 * alike, 0.1 * differ).ids == pair.ids


def test_one_id_is_no_average_and_no_mark_no_pair() -> None:
    rng = np.random.default_rng(13)
    alike, differ = average_of(77, 77, 1200, rng)
    assert CODEC.decode_pair(alike, differ).log10_chances[0] == 0.0
    alike, differ = (rng.choice([-1.0, 0.0, 1.0], CODEC.n) for _ in range(2))
    assert min(CODEC.decode_pair(alike, differ).log10_chances) > -3.0


def test_listed_ids_are_told_apart_by_fewer_carriers_than_all_ids() -> None:
    rng = np.random.default_rng(14)
    llr = observe(5, 60, 0.05, rng)
    assert CODEC.decode(llr).id is None
    words = CODEC.words([3, 4, 5, 6])
    chances = CODEC.chances(llr, words)
    assert chances.argmin() == 2
    assert chances[2] < CHECK_WORD_LIMIT
    assert (np.delete(chances, 2) > -3.0).all()


def test_a_longer_list_asks_for_as_much_more() -> None:
    llr = observe(5, 60, 0.05, np.random.default_rng(15))
    few = CODEC.chances(llr, CODEC.words([5]))[0]
    many = CODEC.chances(llr, CODEC.words(list(range(64))))[5]
    assert many - few == pytest.approx(6 * log10(2.0))


def test_words_are_the_code_bits_of_ids() -> None:
    rng = np.random.default_rng(5)
    for count in (2, 500):  # each on its own, and by tables
        ids = [2**64 - 1, *(int(each) for each in rng.integers(2**63, size=count - 1))]
        words, llr = CODEC.words(ids), rng.normal(size=CODEC.n) * (rng.random(CODEC.n) < 0.3)
        expected = np.array([CODEC.encode(each) for each in ids])
        assert np.array_equal(words.bits(), expected)
        assert words.agreement(llr) == pytest.approx((1.0 - 2.0 * expected) @ llr)
    assert CODEC.words([]).bits().shape == (0, CODEC.n)
    with pytest.raises(InputError, match="64-bit"):
        CODEC.words([-1])
    for wrong in (np.zeros(3), np.full(CODEC.n, np.nan)):
        with pytest.raises(InputError, match="expected 4096 finite numbers"):
            CODEC.chances(wrong, CODEC.words([1]))
        with pytest.raises(InputError, match="expected 4096 finite numbers"):
            CODEC.decode_pair(np.zeros(CODEC.n), wrong)


def test_a_word_of_32_bits_takes_fewer_carriers_and_is_never_one_of_64() -> None:
    rng = np.random.default_rng(32)
    ids = [short_id(int(rng.integers(2**32))) for _ in range(20)]
    seen = [observe(identity, 70, 0.0, rng) for identity in ids]
    assert [CODEC.decode_short(llr, -7.0).id for llr in seen] == ids
    assert [CODEC.decode(llr, -3.0).id for llr in seen] == [None] * len(ids)
    many = [observe(identity, 700, 0.1, rng) for identity in ids]
    assert [CODEC.decode_short(llr, -7.0).id for llr in many] == ids
    assert [CODEC.decode(llr, -3.0).id for llr in many] == [None] * len(ids)
    long = [observe(int(rng.integers(2**63)), 700, 0.1, rng) for _ in range(20)]
    assert [CODEC.decode_short(llr, -3.0).id for llr in long] == [None] * len(long)
    assert [OTHER.decode_short(llr, -3.0).id for llr in many] == [None] * len(ids)


def test_too_few_carriers_tell_no_id_of_32_bits_and_never_a_wrong_one() -> None:
    rng = np.random.default_rng(33)
    for carriers, error in [(40, 0.0), (70, 0.06), (150, 0.2)]:
        for _ in range(40):
            identity = short_id(int(rng.integers(2**32)))
            assert CODEC.decode_short(observe(identity, carriers, error, rng), -7.0).id in (None, identity)


def test_the_mark_without_an_id_is_one_word() -> None:
    rng = np.random.default_rng(34)
    chance = [CODEC.presence_chance(observe(PRESENCE, 20, 0.0, rng)) for _ in range(20)]
    assert max(chance) < -5.0
    others = [OTHER.presence_chance(observe(PRESENCE, 20, 0.0, rng)) for _ in range(2000)]
    assert np.mean(np.array(others) <= -1.0) <= 0.1
    assert np.mean(np.array(others) <= -2.0) <= 0.01
    assert CODEC.decode(observe(PRESENCE, 500, 0.0, rng)).id is None
    assert CODEC.decode_short(observe(PRESENCE, 500, 0.0, rng)).id is None


def test_a_list_may_hold_ids_of_64_and_of_32_bits() -> None:
    ids = [short_id(5), 5, short_id(9), 7]
    words = CODEC.words(ids)
    assert np.array_equal(words.bits(), [CODEC.encode(each) for each in ids])
    for place, identity in enumerate(ids):
        chances = CODEC.chances(observe(identity, 60, 0.0, np.random.default_rng(place)), words)
        assert int(np.argmin(chances)) == place
        assert chances[place] < -12.0


def test_the_code_never_changes() -> None:
    """A digest recorded when the code was fixed; another value would orphan every mark ever made."""
    word = CODEC.encode(0x0123456789ABCDEF)
    assert hashlib.sha256(np.packbits(word).tobytes()).hexdigest() == CODE_DIGEST
    word = np.concatenate([CODEC.encode(short_id(0x01234567)), CODEC.encode(PRESENCE)])
    assert hashlib.sha256(np.packbits(word).tobytes()).hexdigest() == FEWER_DIGEST


@pytest.mark.parametrize("carriers", [64, 100, 150, 1000])
def test_the_bound_holds_and_is_close_for_equal_carriers(carriers: int) -> None:
    """Against the exact binomial tail times 2^64."""
    tail = 0
    for wrong in some(range(carriers // 2)):
        tail += comb(carriers, wrong)
        exact = min(0.0, log10(tail) - carriers * log10(2.0) + 64 * log10(2.0))
        bound = log10_chance(np.full(carriers, 0.3), 0.3 * (carriers - 2 * wrong))
        assert exact - 1e-6 <= bound <= max(exact + 2.5, 0.4 * exact)


def test_the_bound_holds_and_is_close_for_unequal_carriers() -> None:
    """Against the tail of random signs, estimated by sampling under an exponential tilt."""
    rng = np.random.default_rng(0)
    llr = rng.exponential(size=200)
    for tilt in (1.0, 2.0, 4.0):
        agreement = float(llr @ np.tanh(tilt * llr))
        signs = np.where(rng.random((20000, 200)) < 1.0 / (1.0 + np.exp(-2.0 * tilt * llr)), 1.0, -1.0)
        sums = signs @ llr
        weights = np.exp(-tilt * (sums - agreement)) * (sums >= agreement)
        log_tail = np.log(np.cosh(tilt * llr)).sum() - tilt * agreement + np.log(weights.mean())
        exact = min(0.0, float(log_tail / np.log(10.0)) + 64 * log10(2.0))
        assert exact - 0.05 <= log10_chance(llr, agreement) <= exact + 2.5


def test_the_other_of_two_ids_is_told_from_where_they_differ():
    rng = np.random.default_rng(0)
    _, differ = average_of(9, 7, 600, rng)
    other, chance = CODEC.decode_other(9, differ)
    assert other == 7
    assert chance < -30.0
    assert CODEC.decode_other(7, differ)[0] == 9


def test_there_is_no_other_id_where_nothing_differs():
    same = np.bincount(np.random.default_rng(0).integers(0, CODEC.n, 600), minlength=CODEC.n)
    assert CODEC.decode_other(9, same.astype(float)) == (9, 0.0)


def test_a_witness_is_the_ids_own_and_the_keys():
    bits = CODEC.witness(9)
    assert np.array_equal(bits, Codec(KEY).witness(9))
    for other in (CODEC.witness(7), OTHER.witness(9), CODEC.encode(9)):
        assert 0.45 < (other == bits).mean() < 0.55


@pytest.mark.parametrize("soft", [False, True])
def test_below_a_limit_the_same_id_is_told_or_none(soft: bool) -> None:
    """From clean observations to noise: whatever passes is told in full, whatever does not is not told."""
    rng = np.random.default_rng(12)
    told = []
    for error in some(np.tile(np.linspace(0.05, 0.5, 16), 12)):
        llr = observe(int(rng.integers(2**63)), 260, float(error), rng)
        llr = llr * rng.gamma(2.0, 1.0, CODEC.n) if soft else llr
        for limit in (-7.0, CHECK_WORD_LIMIT, -14.0):
            whole, below = CODEC.decode(llr, limit), CODEC.decode_below(llr, limit)
            told.append(whole.id is not None)
            expected = (whole.id, whole.log10_chance, whole.bits.tobytes()) if told[-1] else None
            found = None if below is None else (below.id, below.log10_chance, below.bits.tobytes())
            assert found == expected
    assert 0.15 < np.mean(told) < 0.85


def test_a_limit_that_no_agreement_reaches_is_never_passed() -> None:
    few = np.zeros(CODEC.n)
    few[:80] = 1.0
    assert least_agreement(few, -7.0) == np.inf
    assert CODEC.decode_below(few, -7.0) is None
    assert CODEC.decode_below(np.zeros(CODEC.n), -7.0) is None


@pytest.mark.parametrize("limit", [-7.0, CHECK_WORD_LIMIT, -30.0])
def test_the_least_agreement_is_just_short_of_the_limit(limit: float) -> None:
    rng = np.random.default_rng(5)
    for count in (200, 400, 2000):
        llr = rng.normal(size=count) + 0.3
        least = least_agreement(llr, limit)
        assert log10_chance(llr, least) > limit
        assert log10_chance(llr, 1.01 * least) < limit

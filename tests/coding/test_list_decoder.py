from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.list_decoder import ListDecoder
from meshmark.coding.polar import polar_code
from tests.counting import some

SUBKEY = bytes(range(32))


@pytest.mark.parametrize(
    ("length", "bits", "checks"), [(16, 5, 0), (32, 8, 2), (64, 9, 8), (16, 10, 6), (8, 8, 0)]
)
def test_a_long_list_holds_every_word(length: int, bits: int, checks: int) -> None:
    code = polar_code(length, bits, checks, SUBKEY)
    llr = np.random.default_rng(0).standard_normal(length)
    ids, words = ListDecoder(code).decode(llr, 1 << bits)
    assert sorted(ids.tolist()) == list(range(1 << bits))
    for identity, word in some(zip(ids.tolist(), words, strict=True)):
        assert np.array_equal(word, code.encode(identity))


@pytest.mark.parametrize("observed", [64, 40, 20])
def test_a_short_list_holds_the_likeliest_word(observed: int) -> None:
    """Against brute force over all 1,024 words, at a noise where the likeliest word is often a wrong one."""
    code = polar_code(64, 10, 4, SUBKEY)
    all_words = np.array([code.encode(identity) for identity in range(1024)])
    decoder = ListDecoder(code)
    rng = np.random.default_rng(observed)
    found = 0
    for _ in range(100):
        sent = 1.0 - 2.0 * code.encode(int(rng.integers(1024)))
        llr = (sent + rng.normal(0.0, 1.2, 64)) * (rng.permutation(64) < observed)
        likeliest = int(np.argmax((1.0 - 2.0 * all_words) @ llr))
        ids, _ = decoder.decode(llr, 32)
        found += likeliest in ids.tolist()
    assert found >= 97


def test_one_path_reads_a_clean_word_and_no_scale_matters() -> None:
    code = polar_code(512, 64, 8, SUBKEY)
    decoder = ListDecoder(code)
    rng = np.random.default_rng(3)
    for _ in range(20):
        identity = int(rng.integers(2**63))
        llr = 1.0 - 2.0 * code.encode(identity)
        for scale in (1e-6, 1.0, 1e6):
            assert decoder.decode(scale * llr, 1).ids.tolist() == [identity]


def test_nothing_observed_gives_words_of_the_code() -> None:
    code = polar_code(256, 64, 8, SUBKEY)
    ids, words = ListDecoder(code).decode(np.zeros(256), 8)
    assert len(set(ids.tolist())) == 8
    assert np.array_equal(words[3], code.encode(int(ids[3])))


@pytest.mark.parametrize(("decibel", "limit"), [(1.0, 0.10), (2.0, 0.01)])
def test_the_published_frame_error_rate_is_reached(decibel: float, limit: float) -> None:
    """64 bits in 256, list of 8: CRC-aided polar codes have .10 and .003 at Eb/N0 of 1 and 2 dB."""
    code = polar_code(256, 64, 8, SUBKEY)
    decoder = ListDecoder(code)
    sigma = np.sqrt(0.5 / (64 / 256 * 10.0 ** (decibel / 10.0)))
    rng = np.random.default_rng(4)
    wrong = 0
    for _ in range(400):
        identity = int(rng.integers(2**63))
        llr = 1.0 - 2.0 * code.encode(identity) + rng.normal(0.0, sigma, 256)
        ids, words = decoder.decode(llr, 8)
        wrong += int(ids[np.argmax((1.0 - 2.0 * words) @ llr)]) != identity
    assert wrong / 400 < limit


def test_a_search_for_words_that_contradict_little_has_them_or_ends_early() -> None:
    code = polar_code(256, 64, 8, SUBKEY)
    decoder = ListDecoder(code)
    rng = np.random.default_rng(6)
    early = 0
    for noise in some(np.tile([0.6, 1.0, 3.0], 40)):
        llr = 1.0 - 2.0 * code.encode(int(rng.integers(2**63))) + rng.normal(0.0, noise, 256)
        whole = decoder.decode(llr, 8)
        contradicted = np.where((1.0 - 2.0 * whole.words) * llr < 0.0, np.abs(llr), 0.0).sum(axis=1).min()
        enough = decoder.decode(llr, 8, most=contradicted * (1.0 + 1e-9))
        assert np.array_equal(enough.ids, whole.ids)
        assert np.array_equal(enough.words, whole.words)
        less = decoder.decode(llr, 8, most=0.5 * contradicted)
        assert len(less.ids) in (0, len(whole.ids))
        early += not len(less.ids)
    assert early > 100

"""Words of places that are hashed once."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest

from meshmark.coding import known_words
from meshmark.coding.keyed import cell_words
from meshmark.coding.known_words import KnownWords

SUBKEY = bytes(range(32))


def places(seed: int, count: int, reach: int = 4) -> np.ndarray:
    return np.random.default_rng(seed).integers(-reach, reach, (count, 3))


@pytest.mark.parametrize("reach", [2, 5, 1 << 19, 1 << 40])
def test_words_are_those_of_each_place_whatever_was_asked_before(reach):
    known = KnownWords(SUBKEY, 3)
    for seed in range(6):
        asked = places(seed, 40 * seed, reach)
        assert np.array_equal(known.of(asked), cell_words(SUBKEY, asked, 3))


def test_a_place_is_hashed_once():
    known, hashed = KnownWords(SUBKEY, 7), []

    def counting(subkey, coordinates, words):
        hashed.append(len(coordinates))
        return cell_words(subkey, coordinates, words)

    asked = np.unique(places(1, 200), axis=0)
    with patch.object(known_words, "cell_words", counting):
        known.of(asked[::2])
        known.of(asked)
        known.of(asked[::-1])
    assert hashed == [len(asked[::2]), len(asked[1::2])]


def test_what_is_kept_is_bounded(monkeypatch):
    monkeypatch.setattr(known_words, "_MOST", 1000)
    known = KnownWords(SUBKEY, 2)
    for seed in range(20):
        asked = places(seed, 50, 50)
        assert np.array_equal(known.of(asked), cell_words(SUBKEY, asked, 2))
        assert known._words.nbytes < 2000

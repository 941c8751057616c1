"""Keyed numbers of rings are those that hashing gives, and hashed once for each unit of length."""

from __future__ import annotations

import numpy as np

from meshmark.authentication.checks import words_once
from meshmark.authentication.checks.words_once import WordsOnce
from meshmark.authentication.marks.ring_ways import WORDS
from meshmark.authentication.parameters import LEVELS
from meshmark.coding.keyed import cell_words

SUBKEY = bytes(range(32))


def test_numbers_are_those_of_hashing_and_each_is_hashed_once(monkeypatch):
    hashed = []

    def counted(subkey, read, words):
        hashed.append(len(read))
        return cell_words(subkey, read, words)

    monkeypatch.setattr(words_once, "cell_words", counted)
    rng = np.random.default_rng(1)
    ring, column = np.nonzero(np.ones((5, len(LEVELS))))
    level = column + LEVELS[0]
    # What was read in units of 1, and for the first two levels also in units of 2.
    plain, coarse = rng.integers(-9, 9, (2, len(ring), 8))
    first = column < 2
    once = WordsOnce(SUBKEY, 5)
    for rows, read, cell in (
        (np.flatnonzero(column < 4), plain, np.ones(len(ring))),
        (np.arange(len(ring)), plain, np.ones(len(ring))),
        (np.arange(len(ring)), np.where(first[:, None], coarse, plain), np.where(first, 2.0, 1.0)),
    ):
        found = once.of(ring[rows], level[rows])(read[rows], cell[rows])
        np.testing.assert_array_equal(found, cell_words(SUBKEY, read[rows], WORDS))
    assert hashed == [20, 5 * len(LEVELS) - 20, 10]

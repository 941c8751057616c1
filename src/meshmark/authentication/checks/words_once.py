"""Keyed numbers of rings that are read with many levels and in several styles: each is hashed once."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.ring_ways import WORDS, Hash
from meshmark.authentication.parameters import LEVELS
from meshmark.coding.keyed import cell_words
from meshmark.mesh import FloatArray, IntArray

__all__ = ["WordsOnce"]


class WordsOnce:
    """Numbers of the plain way to read each of r rings, under a subkey.

    What is hashed follows from the ring, the level and the unit of length, which is the same in all styles but for
    the coarsest steps. Takes 2 kB for each ring.
    """

    def __init__(self, subkey: bytes, count: int) -> None:
        self._subkey = subkey
        self._words = np.zeros((count * len(LEVELS), WORDS), np.uint64)
        self._cell = np.zeros(count * len(LEVELS))  # in which they were read, 0 where they were not yet

    def of(self, ring: IntArray, level: IntArray) -> Hash:
        """Return what gives the numbers of these rings (n,), read with these levels (n,)."""
        return partial(self._hashed, ring * len(LEVELS) + (level - LEVELS[0]))

    def _hashed(self, place: IntArray, read: IntArray, cell: FloatArray) -> NDArray[np.uint64]:
        new = np.flatnonzero(self._cell[place] != cell)
        if len(new) == len(place):
            words = cell_words(self._subkey, read, WORDS)
            self._words[place] = words
        else:
            self._words[place[new]] = cell_words(self._subkey, read[new], WORDS)
            words = self._words[place]
        self._cell[place] = cell
        return words

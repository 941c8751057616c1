"""The keyed words of places that are asked for again and again, each of them hashed once.

The cells, or cubes, that a surface touches hardly change where it is moved a little or read in a corrected frame.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import cell_words
from meshmark.mesh import IntArray

__all__ = ["KnownWords"]

# Coordinates from minus this up to it have numbers by which they are found again.
_REACH: Final = 1 << 20
# Words that are kept at most, in bytes: what a search of a large surface needs in one frame.
_MOST: Final = 1 << 24


class KnownWords:
    """`cell_words` of one subkey, (n, words) for integer coordinates (n, 3)."""

    def __init__(self, subkey: bytes, words: int) -> None:
        self._subkey, self._count = subkey, words
        self._forget()

    def of(self, coordinates: IntArray) -> NDArray[np.uint64]:
        """Return the words (n, words) of places (n, 3)."""
        if np.abs(coordinates).max(initial=0) >= _REACH:
            return cell_words(self._subkey, coordinates, self._count)
        x, y, z = coordinates.T + _REACH
        names = (x * (2 * _REACH) + y) * (2 * _REACH) + z
        row = np.searchsorted(self._names, names)
        new = self._names[np.minimum(row, len(self._names) - 1)] != names
        if not new.any():
            return np.asarray(self._words[row])
        asked = coordinates[new]
        fresh = cell_words(self._subkey, asked, self._count)
        words = np.empty((len(names), self._count), np.uint64)
        words[new], words[~new] = fresh, self._words[row[~new]]
        if self._words.nbytes + fresh.nbytes > _MOST:
            self._forget()
        self._keep(names[new], fresh)
        return words

    def _forget(self) -> None:
        self._names = np.full(1, np.iinfo(np.int64).max)
        self._words = np.zeros((1, self._count), np.uint64)

    def _keep(self, names: IntArray, words: NDArray[np.uint64]) -> None:
        names, first = np.unique(names, return_index=True)
        at = np.searchsorted(self._names, names)
        self._names = np.insert(self._names, at, names)
        self._words = np.insert(self._words, at, words[first], axis=0)

"""Many code words at once: made from tables, eight bits to the byte, and compared with observations by tables.

The code is linear: the word of an id is the sum (XOR) of the words of its bytes, and an agreement with observations
the sum of what each byte of the word agrees. For 10,000 ids both take hundredths of a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.polar import Bits, PolarCode, parity, polar_transform
from meshmark.mesh import FloatArray

__all__ = ["WordList", "joined", "word_list"]

_BYTE = 8
# Tables are worth their making for more ids than this.
_FEW = 128
# Bits of each value of a byte, the first one highest, as numpy packs them.
_BITS = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1)


@dataclass(frozen=True, eq=False)
class WordList:
    """m code words of n bits; packed: (n / 8, m), byte by byte."""

    packed: NDArray[np.uint8]

    def __len__(self) -> int:
        return int(self.packed.shape[1])

    def bits(self) -> Bits:
        """Return the words (m, n), a bit each."""
        return np.unpackbits(self.packed, axis=0).T

    def agreement(self, llr: FloatArray) -> FloatArray:
        """Return the sum (m,) of the observations (n,), each with the sign that the word predicts."""
        values = llr.reshape(-1, _BYTE)
        tables = values @ (1.0 - 2.0 * _BITS.T)
        total = np.zeros(len(self))
        for place in np.flatnonzero(values.any(axis=1)):
            total += tables[place].take(self.packed[place])
        return total


def word_list(code: PolarCode, ids: Sequence[int], mask: Bits) -> WordList:
    """Return the words of ids of up to 64 bits, each XORed with a mask (n,)."""
    masked = np.packbits(mask)
    if len(ids) <= _FEW:
        rows = [np.packbits(code.encode(each)) ^ masked for each in ids]
        return WordList(np.array(rows, np.uint8).reshape(len(ids), len(masked)).T)
    sets = polar_transform(code.sums)  # which bits of the id each bit of a word sums
    numbers = np.array(ids, np.uint64)
    words = np.broadcast_to(masked, (len(ids), len(masked))).copy()
    for place in range(0, 64, _BYTE):
        values = np.arange(256, dtype=np.uint64) << np.uint64(place)
        table = np.packbits(parity(sets & values[:, None]), axis=1)
        words ^= table[(numbers >> np.uint64(place)).astype(np.int64) & 0xFF]
    return WordList(np.ascontiguousarray(words.T))


def joined(parts: Sequence[tuple[Sequence[int], WordList]]) -> WordList:
    """Return one list of several, each with the places, in the whole, of its words."""
    places = np.concatenate([np.asarray(own, np.int64) for own, _ in parts])
    packed = np.concatenate([words.packed for _, words in parts], axis=1)
    return WordList(np.ascontiguousarray(packed[:, np.argsort(places)]))

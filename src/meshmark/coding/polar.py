"""A polar code whose frozen bits are keyed: an id of up to 64 bits in n code bits, as one linear code.

Polar transform: x = u F^(x m), F = [[1, 0], [1, 1]] (Arikan 2009). The id bits stand at reliable positions of
u. Every other position after the first id bit holds a keyed random sum of the id bits before it ("dynamic
frozen bits", Trifonov 2016). So the check is spread over the whole code: it costs no rate, it tells paths
apart while the list decoder runs, and it removes the low-weight words that make a plain polar code confuse
neighbours.

A sum of id bits is written as one 64-bit set: bit j of it says whether bit j of the id takes part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import keyed_words
from meshmark.errors import InputError
from meshmark.mesh import IntArray

__all__ = ["Bits", "PolarCode", "Sets", "parity", "polar_code", "polar_transform", "reliability_order"]

Bits = NDArray[np.uint8]
Sets = NDArray[np.uint64]
Word = TypeVar("Word", np.uint8, np.uint64)


@dataclass(frozen=True, eq=False)
class PolarCode:
    """A linear code of length n, a power of two.

    sums:      (n,) which id bits each position of u sums
    positions: (k,) increasing; at position j of them stands bit j of the id alone
    """

    sums: Sets
    positions: IntArray

    def encode(self, identity: int) -> Bits:
        """Return the code word (n,) of an id of k bits."""
        return polar_transform(parity(self.sums & np.uint64(identity)))


def parity(sets: Sets) -> Bits:
    """Return the sum modulo 2 of the bits of each 64-bit set, same shape."""
    return np.asarray(np.bitwise_count(sets) & np.uint8(1))


def polar_transform(u: NDArray[Word]) -> NDArray[Word]:
    """Return u F^(x m) along the last axis, whose length is a power of two; sums are XOR; its own inverse."""
    x = np.array(u)
    half = 1
    while half < x.shape[-1]:
        pairs = x.reshape(*x.shape[:-1], -1, 2, half)
        pairs[..., 0, :] ^= pairs[..., 1, :]
        half *= 2
    return x


def reliability_order(length: int) -> IntArray:
    """Return the positions of u from the least to the most reliable, by polarisation weight: (length,).

    The weight of a position is the sum of 2^(b/4) over its set bits b (He et al. 2017): one order for all
    channels, as ours ranges from few clean carriers to thousands of noisy ones.
    """
    if length < 1 or length & (length - 1):
        raise InputError(f"the code length {length} is not a power of two")
    bits = np.arange(length.bit_length() - 1)
    weight = ((np.arange(length)[:, None] >> bits & 1) * 2.0 ** (bits / 4.0)).sum(axis=1)
    return np.argsort(weight, kind="stable").astype(np.int64)


def polar_code(length: int, bits: int, checks: int, subkey: bytes) -> PolarCode:
    """Build the code of `bits` information bits in `length`, with `checks` keyed checks at good positions.

    Of the bits + checks most reliable positions the first `bits`, as they are decoded, carry the information.
    Raises `InputError` where they do not fit, or for more than 64 bits.
    """
    if not (0 < bits <= 64 and 0 <= checks <= length - bits):
        raise InputError(f"{bits} bits and {checks} checks do not fit a code of length {length}")
    positions = np.sort(reliability_order(length)[length - bits - checks :])[:bits]
    powers = np.uint64(1) << np.arange(bits, dtype=np.uint64)
    alone = np.zeros(length, dtype=np.uint64)
    alone[positions] = powers
    earlier = np.bitwise_or.accumulate(alone) ^ alone
    sums = np.where(alone != 0, alone, keyed_words(subkey, length) & earlier)
    return PolarCode(sums, positions)

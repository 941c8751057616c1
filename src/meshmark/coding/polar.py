"""A polar code whose frozen bits are keyed: 64 id bits in n code bits, as one linear code.

Polar transform: x = u F^(x m), F = [[1, 0], [1, 1]] (Arikan 2009). The id bits stand at reliable positions of u.
Every other position after the first id bit holds a keyed random sum of the id bits before it ("dynamic frozen
bits", Trifonov 2016), so the check word is spread over the whole code: it costs no rate, it tells paths apart while
the list decoder runs, and it removes the low-weight words that make a plain polar code confuse neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import keyed_bits
from meshmark.errors import InputError

__all__ = ["Bits", "PolarCode", "polar_code", "polar_transform", "reliability_order"]

Bits = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class PolarCode:
    """A linear code: `bits @ generator % 2`, with what the list decoder needs to know of its structure.

    precode:   (k, n) uint8, u = bits @ precode
    generator: (k, n) uint8, the polar transform of every row of `precode`
    positions: (k,) int64, increasing: where bit j stands alone in u
    """

    precode: Bits
    generator: Bits
    positions: NDArray[np.int64]

    @property
    def length(self) -> int:
        """Number of code bits n, a power of two."""
        return self.generator.shape[1]

    def encode(self, bits: Bits) -> Bits:
        """Return the code word (n,) of the bits (k,)."""
        return np.asarray(np.bitwise_xor.reduce(self.generator[np.asarray(bits, dtype=bool)], axis=0))


def polar_transform(u: Bits) -> Bits:
    """Return u F^(x m) along the last axis, whose length is a power of two; its own inverse."""
    x = np.array(u, dtype=np.uint8)
    half = 1
    while half < x.shape[-1]:
        pairs = x.reshape(*x.shape[:-1], -1, 2, half)
        pairs[..., 0, :] ^= pairs[..., 1, :]
        half *= 2
    return x


@lru_cache(maxsize=8)
def reliability_order(length: int) -> tuple[int, ...]:
    """Return the positions of u from the least to the most reliable, by polarisation weight.

    The weight of position i is the sum of 2^(b/4) over the bits b set in i (He et al. 2017): one order for all
    channels, as ours ranges from few clean carriers to thousands of noisy ones.
    """
    if length < 1 or length & (length - 1):
        raise InputError(f"the code length {length} is not a power of two")
    index = np.arange(length)
    bits = np.arange(length.bit_length() - 1)
    weight = ((index[:, None] >> bits & 1) * 2.0 ** (bits / 4.0)).sum(axis=1)
    return tuple(int(i) for i in np.argsort(weight, kind="stable"))


def polar_code(length: int, bits: int, checks: int, subkey: bytes) -> PolarCode:
    """Build the code of `bits` information bits in `length`, with `checks` keyed checks at reliable positions.

    Of the bits + checks most reliable positions the first `bits` (in order of decoding) carry the information.
    """
    if not 0 < bits <= bits + checks <= length:
        raise InputError(f"{bits} bits and {checks} checks do not fit a code of length {length}")
    positions = np.sort(reliability_order(length)[length - bits - checks :])[:bits].astype(np.int64)
    random = keyed_bits(subkey, bits * length).reshape(bits, length)
    precode = random * (positions[:, None] < np.arange(length)).astype(np.uint8)
    precode[:, positions] = np.eye(bits, dtype=np.uint8)
    return PolarCode(precode, polar_transform(precode), positions)

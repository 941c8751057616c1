"""Payload bits under a key, for schemes that were published without one.

The code bits are the payload and a few pilots, bits that only the key holder can expect; all are scrambled by a
keyed stream and put in a keyed order. With another key every bit is read as a fair coin. A mark counts as present
where the number of correct pilots is one that chance reaches at most once in 1,000: the exact binomial tail.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import binom

from meshmark.coding.keyed import keyed_bits, keyed_words
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.scheme import Bits, Readout

__all__ = ["PRESENT", "chips", "coded", "order_of", "read_code", "votes"]

PRESENT = -3.0
"""log10 of the chance at which a mark counts as present."""


def coded(bits: Bits, key: Key, pilots: int) -> Bits:
    """Return the code bits (pilots + n,) that stand for a payload (n,)."""
    plain = np.concatenate([np.zeros(pilots, np.uint8), np.asarray(bits, np.uint8)])
    scrambled: Bits = plain ^ keyed_bits(key.subkey("rival stream"), len(plain))
    return scrambled[order_of(key, "rival order", len(plain))]


def read_code(seen: FloatArray, key: Key, pilots: int, hypotheses: int = 1) -> Readout:
    """Return what was read, from one number (c,) for each code bit: positive for 0, 0 where nothing was seen.

    hypotheses: how many readings were tried to get this one; the false-positive bound counts them.
    """
    plain = np.empty(len(seen))
    plain[order_of(key, "rival order", len(seen))] = seen
    bits = (plain < 0.0).astype(np.uint8) ^ keyed_bits(key.subkey("rival stream"), len(seen))
    looked = plain[:pilots] != 0.0
    wrong = int((bits[:pilots] & looked).sum())
    chance = float(binom.logcdf(wrong, int(looked.sum()), 0.5)) if pilots else 0.0
    bound = min(0.0, float(chance / np.log(10.0) + np.log10(hypotheses)))
    return Readout(bits=bits[pilots:], present=bound <= PRESENT, log10_false_positive=bound)


def chips(key: Key, purpose: str, count: int, length: int) -> tuple[IntArray, FloatArray]:
    """Return for each of `count` carriers the code bit it holds, each about as often, and a sign, both keyed."""
    bit = order_of(key, purpose, count) % length
    return bit, np.asarray(1.0 - 2.0 * keyed_bits(key.subkey(f"{purpose} signs"), count), np.float64)


def votes(bit: IntArray, values: FloatArray, length: int) -> FloatArray:
    """Return (length,): the sum of the values of the carriers of each code bit."""
    return np.bincount(bit.ravel(), values.ravel(), length).astype(np.float64)


def order_of(key: Key, purpose: str, count: int) -> IntArray:
    """Return a keyed permutation (count,)."""
    return np.argsort(keyed_words(key.subkey(purpose), count), kind="stable")

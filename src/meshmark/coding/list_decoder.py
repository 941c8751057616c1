"""Successive-cancellation list decoding of the polar code, whole subtrees at a time.

The tree of a polar code is walked as in Tal and Vardy (2015): left half by f (both code bits combined), right half
by g (given the left half), with the best `paths` decisions kept. A subtree that holds few id bits is not walked:
all its words are compared at once, one matrix product for all paths, which is exact and makes it fast in numpy.
A subtree without any id bit is the case of one word per path; its known bits still tell good paths from bad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.polar import Bits, PolarCode, polar_transform
from meshmark.mesh import FloatArray

__all__ = ["ListDecoder"]

Words = NDArray[np.uint64]
# Subtrees of up to 2^6 words are compared whole.
_MAX_CHOICE_BITS = 6


@dataclass(frozen=True, eq=False)
class _Leaf:
    """A subtree of s code bits whose words are compared whole.

    columns: (s,) the id bits that each code bit sums, as a 64-bit set, without those decided here
    ids:     (c,) the c choices for the id bits decided here, as 64-bit sets
    choices: (c, s) the word of every choice, added to what earlier id bits make of `columns`
    """

    columns: Words
    ids: Words
    choices: Bits


@dataclass(eq=False)
class _Paths:
    """The decisions kept so far: id bits as 64-bit sets (p,) and penalty -log P (p,)."""

    ids: Words
    penalty: FloatArray


class ListDecoder:
    """A list decoder for one code of up to 64 bits; keeps no state between calls."""

    def __init__(self, code: PolarCode) -> None:
        self._bits, self._length = code.precode.shape
        self._leaves: dict[tuple[int, int], _Leaf] = {}
        self._plan(code, 0, self._length)

    def decode(self, llr: FloatArray, paths: int) -> Bits:
        """Return the information bits of the kept words, (at most `paths`, k), the likeliest first.

        llr: (n,) log-likelihood ratios, positive where a code bit is more likely 0.
        """
        state = _Paths(np.zeros(1, dtype=np.uint64), np.zeros(1))
        self._walk(state, 0, np.asarray(llr, dtype=np.float64)[None], paths)
        ids = state.ids[np.argsort(state.penalty, kind="stable")]
        return (ids[:, None] >> np.arange(self._bits, dtype=np.uint64) & np.uint64(1)).astype(np.uint8)

    def _plan(self, code: PolarCode, start: int, size: int) -> None:
        here = np.flatnonzero((code.positions >= start) & (code.positions < start + size))
        if len(here) > _MAX_CHOICE_BITS and size > 1:
            self._plan(code, start, size // 2)
            self._plan(code, start + size // 2, size // 2)
            return
        words = polar_transform(code.precode[:, start : start + size])
        numbers = np.arange(1 << len(here), dtype=np.uint64)
        picks = (numbers[:, None] >> np.arange(len(here), dtype=np.uint64) & np.uint64(1)).astype(np.uint8)
        choices = (picks.astype(np.int64) @ words[here] & 1).astype(np.uint8)
        powers = np.uint64(1) << np.arange(self._bits, dtype=np.uint64)
        before = np.delete(np.arange(self._bits), here)
        columns = (words[before] * powers[before, None]).sum(axis=0, dtype=np.uint64)
        ids = (picks * powers[here]).sum(axis=1, dtype=np.uint64)
        self._leaves[start, size] = _Leaf(columns, ids, choices)

    def _walk(self, state: _Paths, start: int, llr: FloatArray, paths: int) -> tuple[Bits, NDArray[np.int64]]:
        """Decide a subtree given its LLRs (p, s): words (q, s), and from which of the p paths each came (q,)."""
        size = llr.shape[1]
        leaf = self._leaves.get((start, size))
        if leaf is not None:
            return _decide(state, leaf, llr, paths)
        half = size // 2
        left_llr, right_llr = llr[:, :half], llr[:, half:]
        left, origin = self._walk(state, start, _both(left_llr, right_llr), paths)
        given = right_llr[origin] + (1.0 - 2.0 * left) * left_llr[origin]
        right, later = self._walk(state, start + half, given, paths)
        return np.hstack([left[later] ^ right, right]), origin[later]


def _both(a: FloatArray, b: FloatArray) -> FloatArray:
    """LLR of the sum of two bits: 2 atanh(tanh(a/2) tanh(b/2)), written so that it neither over- nor underflows."""
    smaller = np.minimum(np.abs(a), np.abs(b))
    correction = np.log1p(np.exp(-np.abs(a + b))) - np.log1p(np.exp(-np.abs(a - b)))
    return np.asarray(np.sign(a) * np.sign(b) * smaller + correction)


def _decide(state: _Paths, leaf: _Leaf, llr: FloatArray, paths: int) -> tuple[Bits, NDArray[np.int64]]:
    known = (np.bitwise_count(state.ids[:, None] & leaf.columns) & 1).astype(np.uint8)
    # -log P of a bit is log(1 + e^-llr) for 0 and llr more for 1; `known` turns the LLRs so that 0 is expected.
    turned = (1.0 - 2.0 * known) * llr
    base = state.penalty + np.logaddexp(0.0, -turned).sum(axis=1)
    if len(leaf.ids) == 1:
        state.penalty = base
        return known, np.arange(len(known))
    penalty = (base[:, None] + turned @ leaf.choices.T).ravel()
    kept = np.argpartition(penalty, paths)[:paths] if len(penalty) > paths else np.arange(len(penalty))
    origin, choice = np.divmod(kept, len(leaf.ids))
    state.penalty = penalty[kept]
    state.ids = state.ids[origin] | leaf.ids[choice]
    return known[origin] ^ leaf.choices[choice], origin

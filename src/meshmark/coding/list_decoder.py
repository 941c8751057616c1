"""Successive-cancellation list decoding of the polar code, whole subtrees at a time.

The tree of a polar code is walked as in Tal and Vardy (2015): left half by f (both code bits combined), right
half by g (given the left half), with the best `paths` decisions kept; min-sum, so the LLRs need no scale.
A subtree that holds few id bits is not walked: all its words are compared at once, one matrix product for all
paths, which is exact and makes it fast in numpy. A subtree without any id bit has one word per path, and
still tells good paths from bad.

The penalty of a path never falls, and at the end it is what the word contradicts the LLRs by, in all: min-sum keeps
that sum from each subtree to its halves. So a search that only wants words which contradict little may stop early.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from meshmark.coding.polar import Bits, PolarCode, Sets, parity, polar_transform
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Candidates", "ListDecoder"]

# Subtrees of up to 2^6 words are compared whole.
_MAX_CHOICE_BITS = 6


class Candidates(NamedTuple):
    """Ids as 64-bit sets (p,), and their code words (p, n)."""

    ids: Sets
    words: Bits


@dataclass(frozen=True, eq=False, kw_only=True)
class _Leaf:
    """A subtree of s code bits whose words are compared whole.

    sums:    (s,) which of the id bits decided earlier each code bit sums
    ids:     (c,) the c choices for the id bits decided here
    choices: (c, s) the word that each choice adds
    """

    sums: Sets
    ids: Sets
    choices: FloatArray


@dataclass(eq=False, kw_only=True)
class _Paths:
    """The decisions kept so far: id bits (p,) and penalty (p,); most: the largest that is of interest."""

    ids: Sets
    penalty: FloatArray
    most: float


class _NoneLeftError(Exception):
    """No path can lead to a word of interest any more."""


class ListDecoder:
    """A list decoder for one code; keeps no state between calls."""

    def __init__(self, code: PolarCode) -> None:
        self._leaves: dict[tuple[int, int], _Leaf] = {}
        self._plan(code, 0, len(code.sums))

    def decode(self, llr: FloatArray, paths: int, most: float = inf) -> Candidates:
        """Return the words kept, at most `paths`.

        llr: (n,) log-likelihood ratios in any scale, positive where 0 is more likely, 0 where unknown.
        most: the sum of those that a word of interest contradicts, at most; where there is no such word, there may
        be none at all.
        """
        state = _Paths(ids=np.zeros(1, dtype=np.uint64), penalty=np.zeros(1), most=most)
        try:
            words, _ = self._walk(state, 0, np.asarray(llr, dtype=np.float64)[None], paths)
        except _NoneLeftError:
            return Candidates(np.zeros(0, np.uint64), np.zeros((0, len(llr)), np.uint8))
        return Candidates(state.ids, words)

    def _plan(self, code: PolarCode, start: int, size: int) -> None:
        inside = (code.positions >= start) & (code.positions < start + size)
        if inside.sum() > _MAX_CHOICE_BITS:
            self._plan(code, start, size // 2)
            self._plan(code, start + size // 2, size // 2)
            return
        ids = np.zeros(1, dtype=np.uint64)
        for bit in np.flatnonzero(inside):
            ids = np.concatenate([ids, ids | np.uint64(1 << int(bit))])
        sums = polar_transform(code.sums[start : start + size])
        choices = parity(sums & ids[:, None]).astype(np.float64)
        self._leaves[start, size] = _Leaf(sums=sums & ~ids[-1], ids=ids, choices=choices)

    def _walk(self, state: _Paths, start: int, llr: FloatArray, paths: int) -> tuple[Bits, IntArray]:
        """Decide a subtree given its LLRs (p, s): words (q, s), and the path (q,) that each continues."""
        size = llr.shape[1]
        leaf = self._leaves.get((start, size))
        if leaf is not None:
            decided = _decide(state, leaf, llr, paths)
            if state.penalty.min() > state.most:
                raise _NoneLeftError
            return decided
        half = size // 2
        left_llr, right_llr = llr[:, :half], llr[:, half:]
        left, origin = self._walk(state, start, _either(left_llr, right_llr), paths)
        given = right_llr[origin] + (1.0 - 2.0 * left) * left_llr[origin]
        right, later = self._walk(state, start + half, given, paths)
        return np.hstack([left[later] ^ right, right]), origin[later]


def _either(a: FloatArray, b: FloatArray) -> FloatArray:
    """LLR of the sum of two bits, min-sum."""
    return np.asarray(np.copysign(np.minimum(np.abs(a), np.abs(b)), a * b))


def _decide(state: _Paths, leaf: _Leaf, llr: FloatArray, paths: int) -> tuple[Bits, IntArray]:
    known = parity(leaf.sums & state.ids[:, None])
    # A bit costs |llr| where it contradicts its sign; `known` turns the LLRs so that 0 is expected, and then
    # a 1 costs llr more than a 0 does, whatever its sign.
    turned = (1.0 - 2.0 * known) * llr
    penalty = state.penalty - np.minimum(turned, 0.0).sum(axis=1)
    if len(leaf.ids) == 1:
        state.penalty = penalty
        return known, np.arange(len(known))
    choices = (penalty[:, None] + turned @ leaf.choices.T).ravel()
    kept = np.argpartition(choices, paths)[:paths] if len(choices) > paths else np.arange(len(choices))
    origin, choice = np.divmod(kept, len(leaf.ids))
    state.penalty = choices[kept]
    state.ids = state.ids[origin] | leaf.ids[choice]
    return known[origin] ^ leaf.choices[choice].astype(np.uint8), origin

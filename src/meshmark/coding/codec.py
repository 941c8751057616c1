"""Id to code bits and back, under a key: what a scheme calls.

The id, permuted under the key, is one word of a keyed linear code, XORed with a keyed mask. Nothing else is
needed for a check: an unmarked model (or a wrong key) shows random code bits, so the chance that *any* of the
2^64 words agrees as well as the one found has a bound that holds for every decoder (`log10_chance`). An id is
returned only where this bound lies under a limit; the default, 2^-32, is the strength of a 32-bit check word.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import log, log2, log10
from typing import Final

import numpy as np

from meshmark.coding.keyed import keyed_bits
from meshmark.coding.keys import Key
from meshmark.coding.list_decoder import ListDecoder
from meshmark.coding.message import ID_BITS, check_id
from meshmark.coding.permutation import IdPermutation
from meshmark.coding.polar import Bits, polar_code
from meshmark.coding.word_list import WordList, word_list
from meshmark.errors import InputError
from meshmark.mesh import FloatArray

__all__ = ["CHECK_WORD_LIMIT", "Codec", "Decoded", "DecodedPair", "log10_chance"]

# Chosen by measurement, docs/decisions/0004-code.md.
LENGTH = 4096
CHECKS = 16
PATHS = 64
CHECK_WORD_LIMIT: Final = -32 * log10(2.0)

# Standard deviations by which an agreement stands out.
NOTABLE = 3.0
_NEWTON_STEPS = 20
_LARGEST_S = 20.0
_TINY = 1e-12


@dataclass(frozen=True, kw_only=True)
class Decoded:
    """What a decoder found.

    id:                 the 64-bit id, or None where nothing passes the limit
    guess:              the id of the best candidate, passed or not
    candidates_tested:  words compared with the observations
    bits:               (n,) the code bits of the best candidate, passed or not
    log10_chance:       log10 of a bound on the chance that random observations agree this well with any word
    """

    id: int | None
    guess: int
    candidates_tested: int
    bits: Bits = field(repr=False)
    log10_chance: float


@dataclass(frozen=True, kw_only=True)
class DecodedPair:
    """What an average of two copies decodes to.

    ids: both, in rising order. log10_chances: bounds on the chance that random observations agree this well with
    any word: of where the two differ, and of what they have in common.
    """

    ids: tuple[int, int]
    log10_chances: tuple[float, float]


class Codec:
    """The keyed code; which cell carries which code bit is the caller's choice."""

    def __init__(self, key: Key) -> None:
        self._code = polar_code(LENGTH, ID_BITS, CHECKS, key.subkey("code"))
        self._permutation = IdPermutation(key.subkey("id permutation"))
        self._mask = keyed_bits(key.subkey("code mask"), LENGTH)
        self._decoder = ListDecoder(self._code)

    @property
    def n(self) -> int:
        """Number of code bits."""
        return LENGTH

    def encode(self, identity: int) -> Bits:
        """Return the code bits (n,) of an id; raises `InputError` where it has more than 64 bits."""
        return self._code.encode(self._permutation.forward(check_id(identity))) ^ self._mask

    def decode(self, llr: FloatArray, log10_limit: float = CHECK_WORD_LIMIT) -> Decoded:
        """Return the id behind the observations.

        llr: (n,) log-likelihood ratio log(P(0)/P(1)) of each code bit in any common scale, the sum over the
             cells that carry it, 0 where none does. On unmarked models its signs must be fair coins.

        Raises `InputError` for any other shape, or numbers that are not finite.
        """
        _check(llr)
        word, image, tested, chance = self._likeliest(llr * (1.0 - 2.0 * self._mask))
        guess = self._permutation.backward(image)
        return Decoded(
            id=guess if chance <= log10_limit else None,
            guess=guess,
            candidates_tested=tested,
            bits=word ^ self._mask,
            log10_chance=chance,
        )

    def decode_pair(self, llr: FloatArray, differ: FloatArray) -> DecodedPair:
        """Return the two ids behind observations of an average of two copies.

        The bits where two words differ are a word themselves, as the code is linear; where they do not, the bits
        are those of either.

        llr: (n,) as `decode` takes it; differ: (n,) log-likelihood ratio log(P(same)/P(different)) of each code bit
        of the two. On unmarked models the signs of both must be fair coins, those of llr whatever the others are.

        Raises `InputError` as `decode` does.
        """
        _check(llr)
        _check(differ)
        between, difference, _, chance = self._likeliest(differ)
        if difference == 0:  # one id, which is no average
            chance = 0.0
        _, image, _, second = self._likeliest(np.where(between == 0, llr * (1.0 - 2.0 * self._mask), 0.0))
        ids = sorted(self._permutation.backward(each) for each in (image, image ^ difference))
        return DecodedPair(ids=(ids[0], ids[1]), log10_chances=(chance, second))

    def words(self, ids: Sequence[int]) -> WordList:
        """Return the code bits of m ids; raises `InputError` where one has more than 64 bits."""
        permuted = [self._permutation.forward(check_id(each)) for each in ids]
        return word_list(self._code, permuted, self._mask)

    def chances(self, llr: FloatArray, words: WordList) -> FloatArray:
        """Return log10 of bounds (m,) on the chance that random observations agree as well with any of m words.

        llr: (n,) as `decode` takes it. Words that agree no better than by half are given 0.
        Raises `InputError` as `decode` does.
        """
        _check(llr)
        values = llr[llr != 0.0]
        agreement = words.agreement(llr)
        chances = np.zeros(len(words))
        # The bound takes a Newton search: only words that may be of interest pay for it.
        for row in np.flatnonzero(agreement > NOTABLE * np.sqrt(values @ values)):
            chances[row] = log10_chance(values, float(agreement[row]), log2(len(words)))
        return chances

    def _likeliest(self, values: FloatArray) -> tuple[Bits, int, int, float]:
        """Return (word, the permuted id, words compared, chance) of the best word of the code without mask."""
        ids, words = self._decoder.decode(values, PATHS)
        seen = np.flatnonzero(values)
        agreement = values.sum() - 2.0 * (words[:, seen] @ values[seen])
        best = int(np.argmax(agreement))
        return words[best], int(ids[best]), len(ids), log10_chance(values, float(agreement[best]))


def _check(llr: FloatArray) -> None:
    if np.shape(llr) != (LENGTH,) or not np.isfinite(llr).all():
        raise InputError(f"the observations have shape {np.shape(llr)}, expected {LENGTH} finite numbers")


def log10_chance(llr: FloatArray, agreement: float, words_log2: float = ID_BITS) -> float:
    """Bound log10 of the chance that random signs agree with any of the 2^64 words as well as given.

    agreement: sum of the LLRs (any shape, any scale), each times the sign that the word predicts.
    For one word Chernoff's bound, prod cosh(s l_i) / e^(s agreement), which holds for every s; times their number.
    words_log2: logarithm of the number of words that were compared, all 2^64 by default.
    """
    magnitudes = np.abs(llr[llr != 0.0])
    if not len(magnitudes) or agreement <= 0.0:
        return 0.0
    scale = magnitudes.mean()
    sizes, target = magnitudes / scale, agreement / scale
    # The best s solves sum l tanh(s l) = agreement; the left side is concave: Newton never overshoots.
    s = 0.0
    for _ in range(_NEWTON_STEPS):
        slope = np.tanh(s * sizes)
        s += max(0.0, target - sizes @ slope) / (sizes**2 @ (1.0 - slope**2) + _TINY)
        s = min(s, _LARGEST_S)
    # log cosh x = x + log(1 + e^-2x) - log 2, stable for large x
    exponent = s * (sizes.sum() - target) + np.log1p(np.exp(-2.0 * s * sizes)).sum() - len(sizes) * log(2.0)
    return min(0.0, float(exponent + words_log2 * log(2.0)) / log(10.0))

"""A keyed linear code for ids of so many bits: permuted under the key, one word of a polar code, under a mask."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log
from typing import Final

import numpy as np

from meshmark.coding.keyed import keyed_bits
from meshmark.coding.keys import Key
from meshmark.coding.list_decoder import ListDecoder
from meshmark.coding.message import ID_BITS
from meshmark.coding.permutation import IdPermutation
from meshmark.coding.polar import Bits, Sets, polar_code
from meshmark.coding.word_list import WordList, word_list
from meshmark.mesh import FloatArray

__all__ = ["CHECKS", "LENGTH", "PATHS", "KeyedCode", "least_agreement", "log10_chance"]

# Chosen by measurement, docs/decisions/0004-code.md.
LENGTH: Final = 4096
CHECKS = 16
PATHS = 64

_NEWTON_STEPS = 20
_LARGEST_S = 20.0
_TINY = 1e-12
_HALVINGS = 14
_ROUNDING = 1e-9


class KeyedCode:
    """The code of a key for numbers of `bits` bits, at most 64; `suffix` tells its subkeys from those of others."""

    def __init__(self, key: Key, bits: int, suffix: str = "") -> None:
        self.bits = bits
        self.mask = keyed_bits(key.subkey(f"code mask{suffix}"), LENGTH)
        self._code = polar_code(LENGTH, bits, CHECKS, key.subkey(f"code{suffix}"))
        self._permutation = IdPermutation(key.subkey(f"id permutation{suffix}"), bits)
        self._decoder = ListDecoder(self._code)

    def encode(self, number: int) -> Bits:
        """Return the code bits (n,) of a number."""
        return self._code.encode(self._permutation.forward(number)) ^ self.mask

    def image(self, number: int) -> int:
        """Return what stands for a number in the code without permutation and mask."""
        return self._permutation.forward(number)

    def number(self, image: int) -> int:
        """Return the number of the word that stands for `image` in the code without permutation and mask."""
        return self._permutation.backward(image)

    def unmasked(self, llr: FloatArray) -> FloatArray:
        """Return observations (n,) of a word without the mask."""
        return llr * (1.0 - 2.0 * self.mask)

    def words(self, numbers: Sequence[int]) -> WordList:
        """Return the code bits of m numbers."""
        return word_list(self._code, [self._permutation.forward(each) for each in numbers], self.mask)

    def likeliest(self, values: FloatArray) -> tuple[Bits, int, int, float]:
        """Return the best word of the code without mask: (word, its image, words compared, log10 of its chance)."""
        return self._best(values, *self._decoder.decode(values, PATHS))

    def likeliest_below(self, values: FloatArray, log10_limit: float) -> tuple[Bits, int, int, float] | None:
        """Return what `likeliest` does, None where no word is less likely by chance than the limit.

        Most of the work is saved then, as paths are followed only while they may lead to such a word.
        """
        observed = float(np.abs(values).sum())
        most = 0.5 * (observed - least_agreement(values, log10_limit, self.bits)) + _ROUNDING * observed
        if most < 0.0:
            return None
        images, words = self._decoder.decode(values, PATHS, most)
        if not len(images):
            return None
        found = self._best(values, images, words)
        return found if found[-1] <= log10_limit else None

    def _best(self, values: FloatArray, images: Sets, words: Bits) -> tuple[Bits, int, int, float]:
        """Return the best of some words (w, n) with these images (w,), as `likeliest` does."""
        seen = np.flatnonzero(values)
        agreement = values.sum() - 2.0 * (words[:, seen] @ values[seen])
        best = int(np.argmax(agreement))
        chance = log10_chance(values, float(agreement[best]), self.bits)
        return words[best], int(images[best]), len(images), chance


def least_agreement(llr: FloatArray, log10_limit: float, words_log2: float = ID_BITS) -> float:
    """Return an agreement below which `log10_chance` is surely above a limit (log10, negative).

    The bound falls as the agreement grows, and where s is best for an agreement, that is sum l tanh(s l): so s is
    sought for which the bound is the limit, and any s that is too small will do.
    """
    magnitudes = np.abs(llr[llr != 0.0])
    if not len(magnitudes):
        return inf
    scale = magnitudes.mean()
    sizes = magnitudes / scale
    target = log10_limit * log(10.0) - words_log2 * log(2.0)
    if target <= -len(sizes) * log(2.0):
        return inf
    low, high = 0.0, _LARGEST_S
    for _ in range(_HALVINGS):
        s = 0.5 * (low + high)
        slope = np.tanh(s * sizes)
        cosh = s * sizes + np.log1p(np.exp(-2.0 * s * sizes)) - log(2.0)
        if float(cosh.sum() - s * (sizes @ slope)) > target:
            low = s
        else:
            high = s
    return float(sizes @ np.tanh(low * sizes)) * float(scale)


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

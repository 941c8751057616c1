"""Id to code bits and back, under a key: what a scheme calls.

The id, permuted under the key, is one word of a keyed linear code, XORed with a keyed mask. Nothing else is
needed for a check: an unmarked model (or a wrong key) shows random code bits, so the chance that *any* of the
2^64 words agrees as well as the one found has a bound that holds for every decoder (`log10_chance`). An id is
returned only where this bound lies under a limit; the default, 2^-32, is the strength of a 32-bit check word.

Ids of 32 bits have a code of their own, and a mark without an id is one word: no word of one is one of another
(docs/decisions/0033-fewer-bits.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log2, log10
from typing import Final

import numpy as np

from meshmark.coding.keyed import keyed_bits
from meshmark.coding.keyed_code import LENGTH, KeyedCode, log10_chance
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, SHORT_BITS, bits_of, short_id
from meshmark.coding.polar import Bits
from meshmark.coding.word_list import WordList, joined
from meshmark.errors import InputError
from meshmark.mesh import FloatArray

__all__ = ["CHECK_WORD_LIMIT", "Codec", "Decoded", "DecodedPair"]

CHECK_WORD_LIMIT: Final = -32 * log10(2.0)

# Standard deviations by which an agreement stands out.
NOTABLE = 3.0


@dataclass(frozen=True, kw_only=True)
class Decoded:
    """What a decoder found.

    id:                 the id, or None where nothing passes the limit
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
        self._key = key
        self._long = KeyedCode(key, ID_BITS)

    @cached_property
    def _short(self) -> KeyedCode:
        return KeyedCode(self._key, SHORT_BITS, f" of {SHORT_BITS} bits")

    @cached_property
    def _presence(self) -> Bits:
        """The word (n,) of the mark without an id."""
        return keyed_bits(self._key.subkey("presence word"), LENGTH)

    @property
    def n(self) -> int:
        """Number of code bits."""
        return LENGTH

    def encode(self, identity: int) -> Bits:
        """Return the code bits (n,) of an id of 64 or 32 bits, or of `PRESENCE`; raises `InputError` for others."""
        bits = bits_of(identity)
        if not bits:
            return self._presence
        return self._long.encode(identity) if bits == ID_BITS else self._short.encode(_serial(identity))

    def decode(self, llr: FloatArray, log10_limit: float = CHECK_WORD_LIMIT) -> Decoded:
        """Return the id of 64 bits behind the observations.

        llr: (n,) log-likelihood ratio log(P(0)/P(1)) of each code bit in any common scale, the sum over the
             cells that carry it, 0 where none does. On unmarked models its signs must be fair coins.

        Raises `InputError` for any other shape, or numbers that are not finite.
        """
        _check(llr)
        return _decoded(self._long, llr, log10_limit)

    def decode_below(self, llr: FloatArray, log10_limit: float) -> Decoded | None:
        """Return what `decode` does where an id passes the limit, else None, which is found out much sooner.

        llr: (n,) as `decode` takes it, raising `InputError` as it does.
        """
        _check(llr)
        code = self._long
        found = code.likeliest_below(code.unmasked(llr), log10_limit)
        return None if found is None else _told(code, found, log10_limit)

    def decode_short(self, llr: FloatArray, log10_limit: float = CHECK_WORD_LIMIT) -> Decoded:
        """Return the id of 32 bits behind the observations, as `decode` does that of 64."""
        _check(llr)
        found = _decoded(self._short, llr, log10_limit)
        identity = None if found.id is None else short_id(found.id)
        return replace(found, id=identity, guess=short_id(found.guess))

    def presence_chance(self, llr: FloatArray) -> float:
        """Return log10 of a bound on the chance that random observations agree as well with the word of no id.

        llr: (n,) as `decode` takes it, raising `InputError` as it does.
        """
        _check(llr)
        agreement = float(llr @ (1.0 - 2.0 * self._presence))
        return log10_chance(llr, agreement, 0.0)

    def decode_pair(self, llr: FloatArray, differ: FloatArray) -> DecodedPair:
        """Return the two ids of 64 bits behind observations of an average of two copies.

        The bits where two words differ are a word themselves, as the code is linear; where they do not, the bits
        are those of either.

        llr: (n,) as `decode` takes it; differ: (n,) log-likelihood ratio log(P(same)/P(different)) of each code bit
        of the two. On unmarked models the signs of both must be fair coins, those of llr whatever the others are.

        Raises `InputError` as `decode` does.
        """
        _check(llr)
        _check(differ)
        between, difference, _, chance = self._long.likeliest(differ)
        if difference == 0:  # one id, which is no average
            chance = 0.0
        common = np.where(between == 0, self._long.unmasked(llr), 0.0)
        _, image, _, second = self._long.likeliest(common)
        ids = sorted(self._long.number(each) for each in (image, image ^ difference))
        return DecodedPair(ids=(ids[0], ids[1]), log10_chances=(chance, second))

    def decode_other(self, identity: int, differ: FloatArray) -> tuple[int, float]:
        """Return the id of 64 bits of the other of two combined copies, and log10 of a bound on its chance.

        identity: of one of the two. differ: as `decode_pair` takes it; the bound takes its signs for those of
        coins where no other copy is there. It is 0 where the other id is the same.

        Raises `InputError` as `decode` does.
        """
        _check(differ)
        _, difference, _, chance = self._long.likeliest(differ)
        other = self._long.number(self._long.image(identity) ^ difference)
        return other, chance if difference else 0.0

    def witness(self, identity: int) -> Bits:
        """Return bits (n,) that depend on key and id by a keyed hash: unlike words they do not add up."""
        return keyed_bits(self._key.subkey(f"witness of {identity:016x}"), LENGTH)

    def words(self, ids: Sequence[int]) -> WordList:
        """Return the code bits of m ids of 64 or 32 bits; raises `InputError` for other numbers."""
        short = [place for place, each in enumerate(ids) if bits_of(each) == SHORT_BITS]
        if not short:
            return self._long.words(ids)
        long = [place for place, each in enumerate(ids) if bits_of(each) == ID_BITS]
        parts = [
            (long, self._long.words([ids[place] for place in long])),
            (short, self._short.words([_serial(ids[place]) for place in short])),
        ]
        return joined(parts)

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


def _serial(identity: int) -> int:
    return identity % (1 << SHORT_BITS)


def _decoded(code: KeyedCode, llr: FloatArray, log10_limit: float) -> Decoded:
    return _told(code, code.likeliest(code.unmasked(llr)), log10_limit)


def _told(code: KeyedCode, found: tuple[Bits, int, int, float], log10_limit: float) -> Decoded:
    word, image, tested, chance = found
    guess = code.number(image)
    return Decoded(
        id=guess if chance <= log10_limit else None,
        guess=guess,
        candidates_tested=tested,
        bits=word ^ code.mask,
        log10_chance=chance,
    )


def _check(llr: FloatArray) -> None:
    if np.shape(llr) != (LENGTH,) or not np.isfinite(llr).all():
        raise InputError(f"the observations have shape {np.shape(llr)}, expected {LENGTH} finite numbers")

"""Decoding of one reading: the id, two of an average, listed ones, or fewer bits; the bound on a false alarm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import log, log10

import numpy as np

from meshmark.coding.codec import CHECK_WORD_LIMIT, Codec, Decoded
from meshmark.coding.message import PRESENCE
from meshmark.coding.word_list import WordList
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CREDIBLE_LOG10,
    FURTHER_SHARE,
    PRESENCE_LOG10,
    PRESENT_LOG10,
    PROVEN_LOG10,
)

__all__ = ["Found", "Listed", "decoded", "lock_bound"]


# What is left, of what chance may do, for ids of 64 bits.
_FIRST_SHARE = 1.0 - 2.0 * FURTHER_SHARE


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """The reading that a search ended with, None where there was nothing to read, and the ids behind it.

    present: a mark of this key is there. ids: one, several where copies were averaged, none where only the lock
    shows it; `PRESENCE` alone of the mark without an id.
    log10_false_positive: bound on the chance of this without a mark, over all that was tried.
    stopped: the time ran out before the search was at its end.
    log10_words: for each id but `PRESENCE` a bound on the chance that a reading of something else tells it, over
    all that was decoded: without the lock, which is no chance where another mark of this key is there.
    combined: several copies were put together, none of which can be told.
    """

    reading: Reading | None
    present: bool
    log10_false_positive: float
    ids: tuple[int, ...] = ()
    stopped: bool = False
    log10_words: tuple[float, ...] = ()
    combined: bool = False

    @property
    def id(self) -> int | None:
        """Return the id where there is one only."""
        return self.ids[0] if len(self.ids) == 1 else None

    @property
    def carriers(self) -> int:
        """Return how many cells were read."""
        return 0 if self.reading is None else len(self.reading.phase)


@dataclass(frozen=True, eq=False, kw_only=True)
class Listed:
    """Issued ids among which that of a copy is looked for, and their code words."""

    ids: tuple[int, ...]
    words: WordList


def decoded(codec: Codec, reading: Reading, listed: Listed, decodings: float = 1.0) -> Found | None:
    """Decode a reading, and, where its lock is credible, its complement, as an average, and among listed ids.

    decodings: what the chance of a word alone is charged for the readings that were decoded before.

    A round shape half a step too large or too small locks as well, with every bit turned round. Where the lock is
    credible, less evidence is asked of the word alone: the bound of both together is asked for in any case, and
    pays for each of the ways in which the reading is decoded. Ids of 32 bits, and the mark without one, are looked
    for there last, at a small share of what chance may do.
    """
    observed, credible = reading.observed(), _is_credible(reading)
    ways = (3 if credible else 1) + bool(listed.ids)  # the word, its complement and a pair; the list
    left = _FIRST_SHARE if credible else 1.0
    charged = _Charged(
        lock=ways * reading.hypotheses / left,
        word=log10((2.0 * (ways - 1) if listed.ids else ways) * decodings / left),
        listed=log10(2.0 * decodings / left),
    )
    if credible and (pair := _pair(codec, reading, observed, charged)) is not None:
        return pair
    named = _among(codec, reading, observed, listed, charged=charged)
    if named is not None and len(named.ids) > 1:  # of an average the likeliest word alone is one of them
        return named
    limit = min(_word_limit(reading), _least_of_word(reading.log10_chance, charged.lock))
    signs = (1.0, -1.0) if credible else (1.0,)
    words = [word for sign in signs if (word := codec.decode_below(sign * observed, limit)) is not None]
    word = min(words, key=lambda each: each.log10_chance, default=None)
    if word is not None and word.id is not None:
        bound = _log10_bound(reading.log10_chance + word.log10_chance, charged.lock)
        if bound <= PRESENT_LOG10:
            return Found(
                reading=reading,
                ids=(word.id,),
                present=True,
                log10_false_positive=bound,
                log10_words=(word.log10_chance + charged.word,),
            )
    if named is not None or not credible:
        return named
    return _short(codec, reading, observed, decodings) or _presence(codec, reading, observed)


def _better_way(decode: Callable[[FloatArray], Decoded], observed: FloatArray) -> Decoded:
    """Return what is decoded from a reading as it is or with every bit turned round, whichever is less of a chance.

    Words of a code may agree with four fifths of the complement of another: the first that passes may be wrong.
    """
    return min((decode(signed) for signed in (observed, -observed)), key=lambda word: word.log10_chance)


def _short(codec: Codec, reading: Reading, observed: FloatArray, decodings: float) -> Found | None:
    """Return the id of 32 bits that a reading tells, as it is or with every bit turned round."""
    word = _better_way(partial(codec.decode_short, log10_limit=PROVEN_LOG10), observed)
    bound = _log10_bound(reading.log10_chance + word.log10_chance, 2.0 * reading.hypotheses / FURTHER_SHARE)
    if word.id is None or bound > PRESENT_LOG10:
        return None
    return Found(
        reading=reading,
        ids=(word.id,),
        present=True,
        log10_false_positive=bound,
        log10_words=(word.log10_chance + log10(2.0 * decodings / FURTHER_SHARE),),
    )


def _presence(codec: Codec, reading: Reading, observed: FloatArray) -> Found | None:
    """Return that a reading is one of the mark without an id, where its word is that of this mark."""
    chance = codec.presence_chance(observed)
    bound = _log10_bound(reading.log10_chance + chance, reading.hypotheses / FURTHER_SHARE)
    if chance > PRESENCE_LOG10 or bound > PRESENT_LOG10:
        return None
    return Found(reading=reading, ids=(PRESENCE,), present=True, log10_false_positive=bound)


@dataclass(frozen=True, kw_only=True)
class _Charged:
    """What is charged: hypotheses for lock and word together, and log10 of those for the word alone.

    Listed ids, where there are any, have half of the latter, the other ways of decoding the rest.
    """

    lock: float
    word: float
    listed: float


def _pair(codec: Codec, reading: Reading, observed: FloatArray, charged: _Charged) -> Found | None:
    """Return the two ids of an average of two copies.

    Where their bits are the same it reads as either, elsewhere half a step off: doubled phases tell which, and make
    a word. The lock is of doubled phases too, and counts for nothing in the bound.
    """
    pair = codec.decode_pair(observed, reading.doubled())
    bound = _log10_bound(sum(pair.log10_chances), charged.lock)
    if max(pair.log10_chances) > PROVEN_LOG10 or bound > PRESENT_LOG10:
        return None
    either = (
        max(pair.log10_chances) + log10(2.0) + charged.word
    )  # where either word is wrong, so are both ids
    return Found(
        reading=reading,
        ids=pair.ids,
        present=True,
        log10_false_positive=bound,
        log10_words=(either, either),
    )


def _among(
    codec: Codec, reading: Reading, observed: FloatArray, listed: Listed, *, charged: _Charged
) -> Found | None:
    """Return those of the listed ids that the reading shows: one, or some of those of averaged copies."""
    if not listed.ids:
        return None
    chances = codec.chances(observed, listed.words)
    shown = np.flatnonzero(chances <= _word_limit(reading))
    bound = _log10_bound(reading.log10_chance + float(chances.min()), charged.lock)
    if not len(shown) or bound > PRESENT_LOG10:
        return None
    best = shown[np.argsort(chances[shown], kind="stable")]
    return Found(
        reading=reading,
        ids=tuple(listed.ids[row] for row in best),
        present=True,
        log10_false_positive=bound,
        log10_words=tuple(float(chances[row]) + charged.listed for row in best),
    )


def _is_credible(reading: Reading) -> bool:
    return reading.log10_chance + log10(reading.hypotheses) < CREDIBLE_LOG10


def _word_limit(reading: Reading) -> float:
    """Return log10 of the chance, at most, of a word that is believed."""
    return PROVEN_LOG10 if _is_credible(reading) else CHECK_WORD_LIMIT


def _log10_bound(log10_chance: float, hypotheses: float) -> float:
    """Bound log10 of the chance that any of the hypotheses is this unlikely.

    A product x of two p-values falls below x by chance with x (1 - ln x): the signs of the bits are fair coins
    whatever the lock, which sees only pilots and doubled phases. For a lock alone this is more than is needed.
    """
    return min(0.0, log10(hypotheses) + log10_chance + log10(1.0 - log10_chance * log(10.0)))


def _least_of_word(lock: float, hypotheses: float) -> float:
    """Return log10 of the chance of a word from which on the bound with this lock is not below what is asked."""
    return PRESENT_LOG10 - log10(hypotheses) - lock


def lock_bound(reading: Reading) -> float:
    """Bound log10 of the chance of the lock of a reading without a mark, over all that was tried."""
    return _log10_bound(reading.log10_chance, reading.hypotheses)

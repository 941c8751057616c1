"""Extraction: from a mesh and a key to presence and id, blind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, log10
from time import perf_counter

import numpy as np

from meshmark.certificate.binding import mismatch, refuse_edited
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.codec import CHECK_WORD_LIMIT, Codec
from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.extraction_result import Evidence, Extraction
from meshmark.ownership.parameters import CREDIBLE_LOG10, PRESENT_LOG10, PROVEN_LOG10
from meshmark.ownership.search.measurement import Reading
from meshmark.ownership.search.search import EFFORTS, Search
from meshmark.ownership.search.strategies import STRATEGIES
from meshmark.ownership.search.trials import OutOfTimeError, TrialCounter
from meshmark.scene.surfaces import surfaces_to_read
from meshmark.threads import on_one_thread

__all__ = ["MODES", "Found", "extract", "extraction_of", "find"]

MODES = {type(None): "blind", Certificate: "certificate", Mesh: "original"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """The reading that a search ended with, None where there was nothing to read, and the ids behind it.

    present: a mark of this key is there. ids: one, several where copies were averaged, none where only the lock
    shows it.
    log10_false_positive: bound on the chance of this without a mark, over all that was tried.
    stopped: the time ran out before the search was at its end.
    """

    reading: Reading | None
    present: bool
    log10_false_positive: float
    ids: tuple[int, ...] = ()
    stopped: bool = False

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
    """Issued ids among which that of a copy is looked for, and their code words (m, n)."""

    ids: tuple[int, ...]
    words: Bits


@on_one_thread
def extract(
    mesh: Mesh,
    key: Key,
    *,
    reference: Certificate | Mesh | None = None,
    search: str = "quick",
    time_limit: float | None = None,
    cut: bool = False,
    among: Sequence[int] = (),
) -> Extraction:
    """Read the id from a mesh with the key alone, or with a reference as well.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
    reference : Certificate or Mesh, optional
        The certificate that was made at embedding, or the unmarked original. The mark is then also read where they
        say that the suspect lies, which survives crops.
    search : str
        "plain" reads the surface as it stands, "quick" also undoes common damage, "wide" also exchanges axes that
        are nearly alike and reads every spacing instead of the first few.
    time_limit : float, optional
        Seconds after which the search stops; the answer is "inconclusive" where the mark was not found by then.
    cut : bool
        Also look for copies of one mesh that have lost a piece.
    among : sequence of int, optional
        Ids of which one may be there: it takes less evidence to tell it from these than from all 2^64, and averages
        of more than two copies name those of them that took part.

    Returns
    -------
    Extraction

    Raises
    ------
    InputError
        The search is unknown, the time limit not above 0, an id has more than 64 bits, the certificate of this key
        was edited, or the mesh has no surface.
    """
    start = perf_counter()
    if search not in EFFORTS:
        raise InputError(f"unknown search '{search}', expected one of {', '.join(EFFORTS)}")
    if time_limit is not None and not time_limit > 0.0:
        raise InputError(f"a time limit of {time_limit:g} seconds is out of range, expected more than 0")
    if isinstance(reference, Certificate):
        refuse_edited(reference, key)
    surfaces = surfaces_to_read(mesh, cut=cut)
    found = find(
        Search(
            surface=next(surfaces),
            key=key,
            effort=search,
            reference=reference,
            copies=surfaces,
            trials=TrialCounter(time_limit),
            among=tuple(dict.fromkeys(among)),
        )
    )
    result = extraction_of(found, Codec(key), MODES[type(reference)], perf_counter() - start)
    remark = mismatch(reference, key, result.id) if isinstance(reference, Certificate) else None
    return result if remark is None else replace(result, advice=f"{result.advice} {remark}")


def find(search: Search) -> Found:
    """Return the first reading that decodes, else the one with the best lock.

    The strategies of `STRATEGIES` that apply are gone through in order. Which readings are tried and decoded does
    not depend on the message. The false-positive bound is the chance of the lock times that of the decoded word,
    times the hypotheses.
    """
    codec = Codec(search.key)
    listed = Listed(ids=search.among, words=codec.words(search.among))
    best: Reading | None = None
    stopped = False
    try:
        for strategy in STRATEGIES:
            for reading in strategy.readings(search) if strategy.applies(search) else ():
                best = _better(best, reading)
                limit = strategy.decode_below
                if (limit is None or reading.log10_chance <= limit) and (
                    found := _decoded(codec, reading, listed)
                ):
                    return found
    except OutOfTimeError:
        stopped = True
    if best is None:
        return Found(reading=None, present=False, log10_false_positive=0.0, stopped=stopped)
    bound = _lock_bound(best)
    return Found(
        reading=best,
        present=bound <= PRESENT_LOG10,
        log10_false_positive=bound,
        stopped=stopped,
    )


def _better(one: Reading | None, other: Reading) -> Reading:
    return other if one is None or _lock_bound(other) < _lock_bound(one) else one


def _decoded(codec: Codec, reading: Reading, listed: Listed) -> Found | None:
    """Decode a reading, and, where its lock is credible, its complement, as an average, and among listed ids.

    A round shape half a step too large or too small locks as well, with every bit turned round. Where the lock is
    credible, less evidence is asked of the word alone: the bound of both together is asked for in any case.
    """
    observed = reading.observed()
    credible = reading.log10_chance + log10(reading.hypotheses) < CREDIBLE_LOG10
    if credible and (pair := _pair(codec, reading, observed)) is not None:
        return pair
    limit = PROVEN_LOG10 if credible else CHECK_WORD_LIMIT
    for signed in (observed, -observed) if credible else (observed,):
        decoded = codec.decode(signed, limit)
        chance = reading.log10_chance + decoded.log10_chance + (log10(2.0) if credible else 0.0)
        bound = _log10_bound(chance, reading.hypotheses)
        if decoded.id is not None and bound <= PRESENT_LOG10:
            return Found(reading=reading, ids=(decoded.id,), present=True, log10_false_positive=bound)
    return _among(codec, reading, observed, listed)


def _pair(codec: Codec, reading: Reading, observed: FloatArray) -> Found | None:
    """Return the two ids of an average of two copies.

    Where their bits are the same it reads as either, elsewhere half a step off: doubled phases tell which, and make
    a word. The lock is of doubled phases too, and counts for nothing in the bound.
    """
    pair = codec.decode_pair(observed, reading.doubled())
    bound = _log10_bound(sum(pair.log10_chances), reading.hypotheses)
    if max(pair.log10_chances) > PROVEN_LOG10 or bound > PRESENT_LOG10:
        return None
    return Found(reading=reading, ids=pair.ids, present=True, log10_false_positive=bound)


def _among(codec: Codec, reading: Reading, observed: FloatArray, listed: Listed) -> Found | None:
    """Return those of the listed ids that the reading shows: one, or some of those of averaged copies."""
    if not listed.ids:
        return None
    chances = codec.chances(observed, listed.words)
    credible = reading.log10_chance + log10(reading.hypotheses) < CREDIBLE_LOG10
    shown = np.flatnonzero(chances <= (PROVEN_LOG10 if credible else CHECK_WORD_LIMIT))
    bound = _log10_bound(reading.log10_chance + float(chances.min()), reading.hypotheses)
    if not len(shown) or bound > PRESENT_LOG10:
        return None
    best = shown[np.argsort(chances[shown], kind="stable")]
    return Found(
        reading=reading, ids=tuple(listed.ids[row] for row in best), present=True, log10_false_positive=bound
    )


def _agreeing(codec: Codec, reading: Reading, identity: int) -> int:
    """Return how many cells say the bits of an id, or, of a shape half a step off, the opposite."""
    keys = reading.measured.keys
    bits = np.where(keys.pilot, 0, codec.encode(identity)[keys.code_index])
    agreeing = int(((np.cos(reading.phase) < 0.0) == (bits == 1)).sum())
    return max(agreeing, len(bits) - agreeing)


def _log10_bound(log10_chance: float, hypotheses: float) -> float:
    """Bound log10 of the chance that any of the hypotheses is this unlikely.

    A product x of two p-values falls below x by chance with x (1 - ln x): the signs of the bits are fair coins
    whatever the lock, which sees only pilots and doubled phases. For a lock alone this is more than is needed.
    """
    return min(0.0, log10(hypotheses) + log10_chance + log10(1.0 - log10_chance * log(10.0)))


def _lock_bound(reading: Reading) -> float:
    return _log10_bound(reading.log10_chance, reading.hypotheses)


def extraction_of(found: Found, codec: Codec, mode: str, seconds: float) -> Extraction:
    """Return what a search found in the words and figures of an answer."""
    reading, bound = found.reading, believable(found.log10_false_positive)
    late = "No mark of this key was found before the time limit; not everything was tried."
    if reading is None:
        advice = late if found.stopped else "The model has too few carriers to tell whether it is marked."
        return Extraction(
            presence="inconclusive",
            id=None,
            log10_false_positive=bound,
            mode=mode,
            carriers=0,
            carriers_agreeing=0,
            lock_score=0.0,
            advice=advice,
            seconds=seconds,
        )
    count = len(reading.phase)
    lock = reading.score / float(reading.measured.keys.weight.sum())
    if found.ids:
        agreeing = max(_agreeing(codec, reading, each) for each in found.ids)
        advice = (
            "The mark was read in the mirror image of the model."
            if reading.mirrored
            else "The mark was read."
        )
        if agreeing < 0.7 * count:
            advice = f"The mark was read, though only {agreeing} of its {count} places still agree."
        if len(found.ids) > 1:
            advice = f"This is an average of copies with different ids; {len(found.ids)} of them were read."
        evidence = tuple(Evidence(layer="cells", id=each, log10_false_positive=bound) for each in found.ids)
        return Extraction(
            presence="present",
            id=found.id,
            ids=found.ids,
            log10_false_positive=bound,
            mode=mode,
            carriers=count,
            carriers_agreeing=agreeing,
            lock_score=lock,
            advice=advice,
            seconds=seconds,
            evidence=evidence,
        )
    presence, advice = "absent", "No mark of this key was found."
    if mode == "blind":
        advice += " Of a part or a badly damaged copy the certificate or the original tells more."
    if found.stopped:
        presence, advice = "inconclusive", late
    if found.present:
        presence, advice = "present", "A mark of this key is there, but too damaged to read its id."
    locked = (Evidence(layer="cells", id=None, log10_false_positive=bound),) if found.present else ()
    return Extraction(
        presence=presence,
        id=None,
        log10_false_positive=bound,
        mode=mode,
        carriers=count,
        carriers_agreeing=0,
        lock_score=lock,
        advice=advice,
        seconds=seconds,
        evidence=locked,
    )

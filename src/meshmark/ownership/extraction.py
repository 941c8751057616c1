"""Extraction: from a mesh and a key to presence and id, blind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from math import inf, log, log10
from time import monotonic, perf_counter

import numpy as np

from meshmark.certificate.binding import refuse_edited, stranger
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.codec import CHECK_WORD_LIMIT, Codec, Decoded
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.weld import Welded
from meshmark.mesh import Mesh
from meshmark.ownership.parameters import CREDIBLE_LOG10, DECODE_LOG10, PRESENT_LOG10, PROVEN_LOG10
from meshmark.ownership.results import Evidence, Extraction
from meshmark.ownership.search.cropped import cropped_readings
from meshmark.ownership.search.locking import locked_readings, registered_readings, stretched_readings
from meshmark.ownership.search.reading import Reading, readings
from meshmark.ownership.search.starting_frames import starting_frames
from meshmark.ownership.search.unsmoothed import unsmoothed_readings
from meshmark.scene.surfaces import surfaces_to_read
from meshmark.threads import on_one_thread

__all__ = ["MODES", "SEARCHES", "Found", "extract", "find"]

SEARCHES = ("quick", "wide")
MODES = {type(None): "blind", Certificate: "certificate", Mesh: "original"}


@dataclass(frozen=True, eq=False)
class Found:
    """The reading that a search ended with, and what it decoded to; None where there was nothing to read.

    present: a mark of this key is there; `decoded` is then its id, or None where the lock alone tells.
    log10_false_positive: bound on the chance of this without a mark, over all that was tried.
    stopped: the time ran out before the search was at its end.
    """

    reading: Reading | None
    decoded: Decoded | None
    present: bool
    log10_false_positive: float
    stopped: bool = False


class _OutOfTime(Exception):
    """The time that a search was given is over."""


@on_one_thread
def extract(
    mesh: Mesh,
    key: Key,
    *,
    reference: Certificate | Mesh | None = None,
    search: str = "quick",
    spacings: Sequence[float] | None = None,
    locking: bool = True,
    time_limit: float | None = None,
    cut: bool = False,
) -> Extraction:
    """Read the id from `mesh` with `key` alone, or with a reference of the model besides.

    reference: the certificate that was made at embedding, or the unmarked original; the mark is then also read
    where they say that the suspect lies, which survives crops.

    search: "quick" tries the signs of the frame's axes, "wide" also exchanges axes that are nearly alike
    and reads every spacing instead of the first few.
    spacings: lattice spacings to read; by default all that an embedding may have chosen.
    locking: also read shapes from before an attack, and correct their frames.
    time_limit: seconds after which a search gives up; "inconclusive" where it had not found the mark by then.
    cut: also look for copies of one mesh that have lost a piece.
    Raises `InputError` for an unknown search, a time limit not above 0, a certificate of this key that was edited,
    or where the mesh has no surface.
    """
    start = perf_counter()
    if search not in SEARCHES:
        raise InputError(f"unknown search '{search}', expected one of {', '.join(SEARCHES)}")
    if time_limit is not None and not time_limit > 0.0:
        raise InputError(f"a time limit of {time_limit:g} seconds is out of range, expected more than 0")
    if isinstance(reference, Certificate):
        refuse_edited(reference, key)
    found = find(mesh, key, search == "wide", spacings, locking, reference, time_limit, cut)
    result = _result(found, Codec(key), MODES[type(reference)], perf_counter() - start)
    remark = stranger(reference, key, result.id) if isinstance(reference, Certificate) else None
    return result if remark is None else replace(result, advice=f"{result.advice} {remark}")


def find(
    mesh: Mesh,
    key: Key,
    wide: bool = False,
    spacings: Sequence[float] | None = None,
    locking: bool = True,
    reference: Certificate | Mesh | None = None,
    time_limit: float | None = None,
    cut: bool = False,
) -> Found:
    """Return the first reading that decodes, else the one with the best lock.

    First the surface is read as it stands, of copies of one mesh one (`surfaces_to_read`); readings whose lock
    stands out are decoded. Then it is read where a
    reference says, its frame corrected, and decoded whatever its lock. With `locking` follow its mirror image,
    what it was before common smoothing, every restoration of its shape, and what it was before a small stretch
    or a planar cut.
    Neither choice depends on the message. The false-positive bound is the chance of the lock times that of the
    decoded word, times the hypotheses.
    """
    codec = Codec(key)
    surfaces = surfaces_to_read(mesh, cut=cut)
    best: Reading | None = None
    tickets = _tickets(inf if time_limit is None else monotonic() + time_limit)
    stopped = False
    try:
        first = next(surfaces)
        for surface in chain([first], surfaces):
            for reading in readings(surface, key, codec.n, tickets, wide, spacings):
                best = _better(best, reading)
                if reading.log10_chance <= DECODE_LOG10 and (found := _decoded(codec, reading)):
                    return found
        for reading in _searched(first, key, codec.n, tickets, wide, spacings, locking, reference):
            best = _better(best, reading)
            if found := _decoded(codec, reading):
                return found
    except _OutOfTime:
        stopped = True
    if best is None:
        return Found(None, None, False, 0.0, stopped)
    bound = _lock_bound(best)
    return Found(best, None, bound <= PRESENT_LOG10, bound, stopped)


def _tickets(end: float) -> Iterator[int]:
    """Number the readings of a search; each asks for its number first, so the time is looked at here."""
    for number in count(1):
        if monotonic() > end:
            raise _OutOfTime
        yield number


def _searched(
    surface: Welded,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    wide: bool,
    spacings: Sequence[float] | None,
    locking: bool,
    reference: Certificate | Mesh | None,
) -> Iterator[Reading]:
    """Yield readings in corrected frames: where a reference says, in the suspect's own, in those before a cut."""
    if reference is not None:
        frames = starting_frames(surface, reference)
        spacing = (reference.spacing,) if isinstance(reference, Certificate) else None
        step = (reference.step,) if isinstance(reference, Certificate) else None
        yield from registered_readings(surface, key, code_length, tickets, frames, spacing, step)
    if locking:
        for reading in readings(_mirrored(surface), key, code_length, tickets, wide, spacings):
            yield replace(reading, mirrored=True)
        yield from unsmoothed_readings(surface, key, code_length, tickets, wide, spacings)
        yield from locked_readings(surface, key, code_length, tickets, wide, spacings)
        yield from stretched_readings(surface, key, code_length, tickets, wide, spacings)
        yield from cropped_readings(surface, surface.points, key, code_length, tickets, wide, spacings)


def _mirrored(surface: Welded) -> Welded:
    return replace(surface, points=surface.points * [-1.0, 1.0, 1.0], faces=surface.faces[:, ::-1])


def _better(one: Reading | None, other: Reading) -> Reading:
    return other if one is None or _lock_bound(other) < _lock_bound(one) else one


def _decoded(codec: Codec, reading: Reading) -> Found | None:
    """Decode a reading, and, where its lock is credible, its complement.

    A round shape half a step too large or too small locks as well, with every bit turned round. Where the lock
    alone proves the mark, less evidence is asked of the code.
    """
    observed = reading.observed(codec.n)
    limit = PROVEN_LOG10 if _lock_bound(reading) <= PRESENT_LOG10 else CHECK_WORD_LIMIT
    credible = reading.log10_chance + log10(reading.hypotheses) < CREDIBLE_LOG10
    for signed in (observed, -observed) if credible else (observed,):
        decoded = codec.decode(signed, limit)
        chance = reading.log10_chance + decoded.log10_chance + (log10(2.0) if credible else 0.0)
        bound = _log10_bound(chance, reading.hypotheses)
        if decoded.id is not None and bound <= PRESENT_LOG10:
            return Found(reading, decoded, True, bound)
    return None


def _log10_bound(log10_chance: float, hypotheses: float) -> float:
    """Bound log10 of the chance that any of the hypotheses is this unlikely.

    A product x of two p-values falls below x by chance with x (1 - ln x): the signs of the bits are fair coins
    whatever the lock, which sees only doubled phases. For a lock alone this is more than is needed.
    """
    return min(0.0, log10(hypotheses) + log10_chance + log10(1.0 - log10_chance * log(10.0)))


def _lock_bound(reading: Reading) -> float:
    return _log10_bound(reading.log10_chance, reading.hypotheses)


def _result(found: Found, codec: Codec, mode: str, seconds: float) -> Extraction:
    reading, bound = found.reading, believable(found.log10_false_positive)
    late = "No mark of this key was found before the time limit; not everything was tried."
    if reading is None:
        advice = late if found.stopped else "The model has too few carriers to tell whether it is marked."
        return Extraction("inconclusive", None, bound, mode, 0, 0, 0.0, advice, seconds)
    count = len(reading.phase)
    lock = reading.score / count
    if found.decoded is not None:
        bits = codec.encode(found.decoded.guess)[reading.keys.code_index]
        agreeing = int(((np.cos(reading.phase) < 0.0) == (bits == 1)).sum())
        agreeing = max(agreeing, count - agreeing)
        advice = (
            "The mark was read in the mirror image of the model."
            if reading.mirrored
            else "The mark was read."
        )
        if agreeing < 0.7 * count:
            advice = f"The mark was read, though only {agreeing} of its {count} places still agree."
        identity = found.decoded.id
        evidence = (Evidence(layer="cells", id=identity, log10_false_positive=bound),)
        return Extraction("present", identity, bound, mode, count, agreeing, lock, advice, seconds, evidence)
    presence, advice = "absent", "No mark of this key was found."
    if mode == "blind":
        advice += " Of a part or a badly damaged copy the certificate or the original tells more."
    if found.stopped:
        presence, advice = "inconclusive", late
    if found.present:
        presence, advice = "present", "A mark of this key is there, but too damaged to read its id."
    locked = (Evidence(layer="cells", id=None, log10_false_positive=bound),) if found.present else ()
    return Extraction(presence, None, bound, mode, count, 0, lock, advice, seconds, locked)

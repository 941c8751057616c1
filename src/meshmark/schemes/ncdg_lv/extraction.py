"""Extraction: from a mesh and a key to presence and id, blind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log, log10
from time import perf_counter

import numpy as np

from meshmark.carriers.quantisation import log_likelihood_ratio
from meshmark.coding.codec import Codec, Decoded
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.parameters import DECODE_LOG10, PRESENT_LOG10
from meshmark.schemes.ncdg_lv.reading import Reading, readings
from meshmark.schemes.ncdg_lv.results import Extraction
from meshmark.schemes.ncdg_lv.threads import on_one_thread

__all__ = ["SEARCHES", "extract"]

SEARCHES = ("quick", "wide")


@on_one_thread
def extract(
    mesh: Mesh, key: Key, *, search: str = "quick", spacings: Sequence[float] | None = None
) -> Extraction:
    """Read the id from `mesh` with `key` alone.

    search: "quick" tries the signs of the frame's axes, "wide" also exchanges axes that are nearly alike
    and reads every spacing instead of the first few.
    spacings: lattice spacings to read; by default all that an embedding may have chosen.

    Hypotheses are scored by their lock, which does not depend on the message; those that stand out are decoded.
    The false-positive bound is the chance of the lock times that of the decoded word, times the hypotheses.
    Raises `InputError` for an unknown search, or where the mesh has no surface.
    """
    start = perf_counter()
    if search not in SEARCHES:
        raise InputError(f"unknown search '{search}', expected one of {', '.join(SEARCHES)}")
    codec = Codec(key)
    best: Reading | None = None
    for reading in readings(weld(mesh), key, codec.n, search == "wide", spacings):
        if best is None or _lock_bound(reading) < _lock_bound(best):
            best = reading
        if reading.log10_chance > DECODE_LOG10:
            continue
        decoded = _decode(codec, reading)
        bound = _log10_bound(reading.log10_chance + decoded.log10_chance, reading.hypotheses)
        if decoded.id is not None and bound <= PRESENT_LOG10:
            return _present(reading, codec, decoded, bound, perf_counter() - start)
    return _without_id(best, perf_counter() - start)


def _decode(codec: Codec, reading: Reading) -> Decoded:
    observed = np.bincount(reading.keys.code_index, log_likelihood_ratio(reading.phase), codec.n)
    return codec.decode(np.asarray(observed, dtype=np.float64))


def _log10_bound(log10_chance: float, hypotheses: int) -> float:
    """Bound log10 of the chance that any of the hypotheses is this unlikely.

    A product x of two p-values falls below x by chance with x (1 - ln x): the signs of the bits are fair coins
    whatever the lock, which sees only doubled phases. For a lock alone this is more than is needed.
    """
    return min(0.0, log10(hypotheses) + log10_chance + log10(1.0 - log10_chance * log(10.0)))


def _lock_bound(reading: Reading) -> float:
    return _log10_bound(reading.log10_chance, reading.hypotheses)


def _present(reading: Reading, codec: Codec, decoded: Decoded, bound: float, seconds: float) -> Extraction:
    bits = codec.encode(decoded.id or 0)[reading.keys.code_index]
    agreeing = int(((np.cos(reading.phase) < 0.0) == (bits == 1)).sum())
    count = len(reading.phase)
    advice = "The mark was read."
    if agreeing < 0.7 * count:
        advice = f"The mark was read, though only {agreeing} of its {count} places still agree."
    return Extraction(
        "present", decoded.id, bound, "blind", count, agreeing, reading.score / count, advice, seconds
    )


def _without_id(best: Reading | None, seconds: float) -> Extraction:
    if best is None:
        advice = "The model has too few carriers to tell whether it is marked."
        return Extraction("inconclusive", None, 0.0, "blind", 0, 0, 0.0, advice, seconds)
    bound = _lock_bound(best)
    count = len(best.phase)
    found = Extraction("absent", None, bound, "blind", count, 0, best.score / count, "", seconds)
    if bound <= PRESENT_LOG10:
        return replace(
            found, presence="present", advice="A mark of this key is there, but too damaged to read its id."
        )
    return replace(found, advice="No mark of this key was found.")

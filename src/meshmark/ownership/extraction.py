"""Extraction: from a mesh and a key to presence and id, blind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import perf_counter

from meshmark.certificate.binding import mismatch, refuse_edited, stated_id
from meshmark.certificate.certificate import Certificate
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import bits_of
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.ownership.answer import extraction_of
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.decoding import Found, Listed, decoded, lock_bound
from meshmark.ownership.extraction_result import Extraction
from meshmark.ownership.parameters import ACCUSED_LOG10, PRESENT_LOG10
from meshmark.ownership.search.search import EFFORTS, Search
from meshmark.ownership.search.strategies import STRATEGIES, Strategy
from meshmark.ownership.search.trials import OutOfTimeError, TrialCounter
from meshmark.scene.surfaces import surfaces_to_read
from meshmark.threads import on_one_thread

__all__ = ["MODES", "checked_request", "extract", "find", "find_copies"]

MODES = {type(None): "blind", Certificate: "certificate", Mesh: "original"}


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
    copies: bool = False,
) -> Extraction:
    """Read the id from a mesh with the key alone, or with a reference as well.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
    reference : Certificate or Mesh, optional
        The certificate that was made at embedding, or the unmarked original. The mark is then also read where they
        say that the suspect lies, which survives crops; and the certificate's id is one of `among`.
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
    copies : bool
        Also ask the fingerprint, where there is one, whether copies were combined.

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
    checked_request(key, reference, search=search, time_limit=time_limit)
    surfaces = surfaces_to_read(mesh, cut=cut)
    asked = Search(
        surface=next(surfaces),
        key=key,
        effort=search,
        reference=reference,
        copies=surfaces,
        trials=TrialCounter(time_limit),
        among=tuple(dict.fromkeys((*among, *_stated(reference, key)))),
    )
    asked = replace(asked, sure=ACCUSED_LOG10 if asked.among else None)
    found = _surely_named(find_copies(asked) if copies else find(asked), asked.among)
    result = extraction_of(found, Codec(key), MODES[type(reference)], perf_counter() - start)
    remark = mismatch(reference, key, result.id) if isinstance(reference, Certificate) else None
    return result if remark is None else replace(result, advice=f"{result.advice} {remark}")


def _stated(reference: Certificate | Mesh | None, key: Key) -> tuple[int, ...]:
    """Return the id that a certificate of this key was made for, where it is one of 64 or 32 bits."""
    identity = stated_id(reference, key) if isinstance(reference, Certificate) else None
    return () if identity is None or not bits_of(identity) else (identity,)


def _surely_named(found: Found, listed: Sequence[int]) -> Found:
    """Return what was found without those of the listed ids that another copy of the model may tell by chance.

    Its lock is no chance, as both have one lattice; only the word is.
    """
    kept = [
        (each, bound)
        for each, bound in zip(found.ids, found.log10_words, strict=False)
        if each not in listed or bound <= ACCUSED_LOG10
    ]
    if len(kept) == len(found.log10_words) or found.reading is None:
        return found
    ids, words = tuple(each for each, _ in kept), tuple(bound for _, bound in kept)
    if ids:
        return replace(found, ids=ids, log10_words=words)
    bound = lock_bound(found.reading)
    return replace(found, ids=(), log10_words=(), present=bound <= PRESENT_LOG10, log10_false_positive=bound)


def checked_request(
    key: Key, reference: Certificate | Mesh | None, *, search: str, time_limit: float | None
) -> None:
    """Raise `InputError` where the search is unknown, the time limit not above 0, or the certificate was edited."""
    if search not in EFFORTS:
        raise InputError(f"unknown search '{search}', expected one of {', '.join(EFFORTS)}")
    if time_limit is not None and not time_limit > 0.0:
        raise InputError(f"a time limit of {time_limit:g} seconds is out of range, expected more than 0")
    if isinstance(reference, Certificate):
        refuse_edited(reference, key)


def find_copies(search: Search) -> Found:
    """Return what `find` does, unless the fingerprint tells several ids, or that no id explains it.

    Cells read the sum of three words as clearly as one, and an average of two as nothing. Where they tell nothing
    and the fingerprint one id, it is that.
    """
    from meshmark.ownership.fingerprint.combined_copies import copies_of

    told = copies_of(search)
    if told is not None and len(told.ids) != 1:
        return told
    found = find(search)
    return told if told is not None and not found.ids else found


def find(search: Search, chosen: Callable[[Strategy], bool] | None = None) -> Found:
    """Return the first reading that decodes, else the one with the best lock.

    The strategies of `STRATEGIES` that apply, and are `chosen` where that is given, are gone through in order.
    Which readings are tried and decoded does not depend on the message. The false-positive bound is the chance of
    the lock times that of the decoded word, times the hypotheses.
    """
    codec = Codec(search.key)
    listed = Listed(ids=search.among, words=codec.words(search.among))
    best: Reading | None = None
    unsure: Found | None = None
    stopped = False
    try:
        for strategy in STRATEGIES if chosen is None else filter(chosen, STRATEGIES):
            for reading in strategy.readings(search) if strategy.applies(search) else ():
                best = _better(best, reading)
                limit = strategy.decode_below
                if (limit is None or reading.log10_chance <= limit) and (
                    found := decoded(codec, reading, listed, search.trials.charge_decoding())
                ):
                    if search.sure is None or _sureness(found) <= search.sure:
                        return found
                    if unsure is None or _sureness(found) < _sureness(unsure):
                        unsure = found
    except OutOfTimeError:
        stopped = True
    if unsure is not None:
        return unsure
    if best is None:
        return Found(reading=None, present=False, log10_false_positive=0.0, stopped=stopped)
    bound = lock_bound(best)
    return Found(
        reading=best,
        present=bound <= PRESENT_LOG10,
        log10_false_positive=bound,
        stopped=stopped,
    )


def _sureness(found: Found) -> float:
    """Return log10 of the chance of the surest id; a mark without one is never sure whose it is."""
    return min(found.log10_words, default=0.0)


def _better(one: Reading | None, other: Reading) -> Reading:
    return other if one is None or lock_bound(other) < lock_bound(one) else one

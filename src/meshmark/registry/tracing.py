"""Whose copy a suspect is: read blind, by its authentication marks, and by the certificates of likely originals.

A suspect is read against the ids that were issued, which takes far less evidence than to tell one of 2^64; what is
charged for that is in docs/decisions/0025-registry.md. In order, until an id is told:

    as it stands      blind, also among the ids of the candidates: whose shape the suspect is a part of
    authentication    marks that survive every cut
    registered        by the certificates of the candidates, each among its own ids
    damage undone     blind again, with all that `extract` tries
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import Any

from meshmark.authentication.reported import with_marks
from meshmark.certificate.binding import refuse_edited
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import read_fields
from meshmark.coding.chance import believable
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import format_id
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.ownership.answer import extraction_of
from meshmark.ownership.decoding import Found
from meshmark.ownership.extraction import find, find_copies
from meshmark.ownership.extraction_result import Extraction
from meshmark.ownership.parameters import ACCUSED_LOG10
from meshmark.ownership.search.search import EFFORTS, Search
from meshmark.ownership.search.strategies import Strategy
from meshmark.ownership.search.trials import TrialCounter
from meshmark.registry.likely_originals import Candidate, candidates
from meshmark.registry.registry import Registry
from meshmark.registry.shape_descriptor import RATIO
from meshmark.scene.surfaces import surfaces_to_read
from meshmark.threads import on_one_thread

__all__ = ["Match", "Trace", "trace"]

# Of the ways in which copies of one original are marked (steps, spacings), this number is tried.
_WAYS = 3
# Candidates that are registered: this number, and those about as likely as the first. The first is searched for at
# all scales, the others about where their descriptors fit.
_REGISTERED, _ALIKE = 4, 0.85
_AROUND = (1.0, RATIO, 1.0 / RATIO)


@dataclass(frozen=True, kw_only=True)
class Match:
    """A recipient whose copy a suspect was made of.

    original: name of its file. log10_false_accusation: bound on the chance that any innocent recipient of the
    registry is named like this. method: "blind", "authentication" or "registered".
    """

    recipient: str | None
    id: int
    original: str
    log10_false_accusation: float
    method: str
    share: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields, the id in hexadecimal."""
        return {
            "recipient": self.recipient,
            "id": format_id(self.id),
            "original": self.original,
            "log10_false_accusation": self.log10_false_accusation,
            "method": self.method,
            "share": self.share,
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Trace:
    """What a suspect tells: the extraction, the originals it was compared with, and the recipients it names."""

    extraction: Extraction
    candidates: tuple[Candidate, ...]
    matches: tuple[Match, ...]
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {
            "matches": [each.to_dict() for each in self.matches],
            "presence": self.extraction.presence,
            "ids": [format_id(each) for each in self.extraction.ids],
            "candidates": [each.name for each in self.candidates],
            "advice": self.extraction.advice,
            "seconds": self.seconds,
        }


@on_one_thread
def trace(
    mesh: Mesh, key: Key, registry: Registry, *, search: str = "quick", time_limit: float | None = None
) -> Trace:
    """Say whose copy a suspect is.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
        With which the copies were marked.
    registry : Registry
    search : str
        "plain", "quick" or "wide", as `extract` takes it.
    time_limit : float, optional
        Seconds after which the search stops.

    Returns
    -------
    Trace
        Its extraction has the mode "registry".

    Raises
    ------
    InputError
        The search is unknown, the time limit not above 0, a certificate of the registry was edited, or the mesh has
        no surface.
    RegistryError
        The registry cannot be read.
    """
    start = perf_counter()
    if search not in EFFORTS:
        raise InputError(f"unknown search '{search}', expected one of {', '.join(EFFORTS)}")
    if time_limit is not None and not time_limit > 0.0:
        raise InputError(f"a time limit of {time_limit:g} seconds is out of range, expected more than 0")
    surfaces = surfaces_to_read(mesh)
    surface = next(surfaces)
    likely = tuple(candidates(registry, surface, key.fingerprint))
    known = _Known(registry=registry, key=key, candidates=likely)
    blind = Search(
        surface=surface,
        key=key,
        effort="plain",
        copies=surfaces,
        among=known.every,
        sure=ACCUSED_LOG10,
        trials=TrialCounter(time_limit),
    )
    found, method = find_copies(blind), "blind"
    result, bounds = extraction_of(found, Codec(key), "registry", 0.0), found.log10_words
    if not _is_sure(found) and not found.stopped:
        marked = with_marks(replace(result, id=None, ids=()), mesh, key)
        if marked.ids:
            result, method, bounds = marked, "authentication", (marked.log10_false_positive,)
        else:
            for way, other in _further(blind, known, search):
                if _tells_more(other, found):
                    found, method = other, way
                if _is_sure(other) or other.stopped:
                    break
            result, bounds = extraction_of(found, Codec(key), "registry", 0.0), found.log10_words
    matches = tuple(known.matches(result.ids, bounds, method))
    seconds = perf_counter() - start
    advice = result.advice
    if result.ids and not matches:
        advice += " The registry has no copy with this id."
    return Trace(
        extraction=replace(result, seconds=seconds, advice=advice),
        candidates=likely,
        matches=matches,
        seconds=seconds,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Known:
    """What a registry holds of the candidates under one key."""

    registry: Registry
    key: Key
    candidates: tuple[Candidate, ...]

    @cached_property
    def ids(self) -> dict[str, tuple[int, ...]]:
        """The ids of the copies of each candidate, by its digest."""
        return {each.digest: self.registry.ids(each.digest, self.key.fingerprint) for each in self.candidates}

    @property
    def every(self) -> tuple[int, ...]:
        """The ids of all candidates."""
        return tuple(dict.fromkeys(one for some in self.ids.values() for one in some))

    def certificates(self, original: str) -> Iterator[Certificate]:
        """Yield a certificate for each of the commonest ways in which copies of an original are marked."""
        for text in self.registry.typical_certificates(original, self.key.fingerprint, _WAYS):
            yield Certificate(**read_fields(text.encode("utf-8")))

    def matches(self, ids: Sequence[int], bounds: Sequence[float], method: str) -> Iterator[Match]:
        """Yield the recipients of ids, whose bounds are given, that may be named."""
        for identity, bound in zip(ids, bounds, strict=True):
            if bound > ACCUSED_LOG10:
                continue
            for copy in self.registry.copies_with_id(identity, self.key.fingerprint):
                yield Match(
                    recipient=copy.recipient,
                    id=identity,
                    original=copy.original_name,
                    log10_false_accusation=believable(bound),
                    method=method,
                )


def _further(blind: Search, known: _Known, search: str) -> Iterator[tuple[str, Found]]:
    """Yield what is found by the certificates of the candidates, then with damage undone, and by which method."""
    for number, each in enumerate(known.candidates[:_REGISTERED]):
        if each.likeness < _ALIKE * known.candidates[0].likeness:
            break
        scales = tuple(each.size * factor for factor in _AROUND) if number else ()
        for certificate in known.certificates(each.digest):
            refuse_edited(certificate, known.key)
            by_it = replace(
                blind, reference=certificate, scales=scales, among=known.ids[each.digest], copies=()
            )
            blind.trials.begin_part()
            yield "registered", find(by_it, _by_reference)
    if search != "plain":
        blind.trials.begin_part()
        yield "blind", find(replace(blind, effort=search, copies=()), _undoing_damage)


def _by_reference(strategy: Strategy) -> bool:
    return strategy.by_reference


def _undoing_damage(strategy: Strategy) -> bool:
    return not strategy.by_reference


def _is_sure(found: Found) -> bool:
    """Return whether somebody may be named."""
    return bool(found.log10_words) and min(found.log10_words) <= ACCUSED_LOG10


def _tells_more(one: Found, other: Found) -> bool:
    """Return whether one says more than the other: surer ids, or a less likely lock."""
    words = [min(each.log10_words, default=0.0) for each in (one, other)]
    if one.ids or other.ids:
        return words[0] < words[1]
    return one.stopped or one.log10_false_positive < other.log10_false_positive

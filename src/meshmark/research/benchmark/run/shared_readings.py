"""What a blind scheme has read is an answer, too, for the schemes that read the same marks with a reference."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import log10
from typing import Any

from meshmark.research.benchmark.run.job import Outcome, shared_mark
from meshmark.research.benchmark.run.row import Case, Row
from meshmark.research.schemes.scheme import SharedMark

__all__ = ["SharedReadings", "blind_of", "outcome_of"]

# Fields of a row that say what was read.
_READ = ("ber", "raw_ber", "correlation", "present", "recovered", "log10_false_positive")
# The chance of being wrong is shared by two readings.
_HALF = log10(2.0)


def blind_of(case: Case, schemes: Iterable[str]) -> Case | None:
    """Return the case in which a blind scheme reads the same suspect, None where none of these schemes does."""
    shared = shared_mark(case.scheme)
    if shared is None or shared.scheme not in schemes:
        return None
    return replace(case, scheme=shared.scheme)


class SharedReadings:
    """Puts together what was read by a reference and blind, whichever comes first.

    schemes: of the run. known: outcomes of blind cases from an earlier start.
    """

    def __init__(self, schemes: Iterable[str], known: Mapping[Case, Outcome]) -> None:
        """Wait for the cases of these schemes."""
        self._schemes = frozenset(schemes)
        self._known = dict(known)
        self._waiting: dict[Case, list[tuple[Case, Outcome, SharedMark]]] = {}

    def settled(self, case: Case, outcome: Outcome) -> list[tuple[Case, Outcome]]:
        """Return the cases that are over now that this one has ended, with their outcomes."""
        blind, shared = blind_of(case, self._schemes), shared_mark(case.scheme)
        if blind is not None and shared is not None and outcome.status == "ok":
            outcome = replace(outcome, figures=_halved(outcome.figures, shared))
            if outcome.figures["present"]:
                return [(case, outcome)]
            if blind in self._known:
                return [(case, _read_blind(outcome, self._known[blind], shared))]
            self._waiting.setdefault(blind, []).append((case, outcome, shared))
            return []
        self._known[case] = outcome
        waited = self._waiting.pop(case, [])
        return [(case, outcome), *((other, _read_blind(told, outcome, mark)) for other, told, mark in waited)]


def outcome_of(row: Row) -> Outcome:
    """Return the outcome that a row was made of."""
    figures = {name: getattr(row, name) for name in (*_READ, "extract_seconds", "peak_mb")}
    return Outcome(status=row.status, note=row.note, figures=figures)


def _read_blind(told: Outcome, blind: Outcome, shared: SharedMark) -> Outcome:
    """Return what was read blind where a reference told nothing, at the cost of both."""
    if blind.status != "ok":
        return blind
    read = _halved({name: blind.figures[name] for name in _READ}, shared)
    points = told.figures["vertices_per_second"] * told.figures["extract_seconds"]
    seconds = told.figures["extract_seconds"] + blind.figures["extract_seconds"]
    peaks = [each.figures["peak_mb"] for each in (told, blind) if each.figures.get("peak_mb")]
    return replace(
        told,
        figures={
            **told.figures,
            **read,
            "extract_seconds": seconds,
            "vertices_per_second": points / seconds,
            "peak_mb": max(peaks, default=None),
        },
    )


def _halved(figures: Mapping[str, Any], shared: SharedMark) -> dict[str, Any]:
    """Return the figures of a reading that has half the chance of being wrong."""
    bound, present = figures["log10_false_positive"], bool(figures["present"])
    if bound is not None:
        bound = min(bound + _HALF, 0.0)
        present = present and bound <= shared.log10_present
    return {
        **figures,
        "log10_false_positive": bound,
        "present": present,
        "recovered": present and bool(figures["recovered"]),
    }

"""What a blind scheme has read is an answer, too, for the schemes that read the same marks with a reference.

A suspect is read blind first, and by the reference where that tells no payload: what both say has twice the chance
of being wrong that each has alone. The time is that of the readings that were made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import log10
from typing import Any

from meshmark.research.benchmark.run.job import Job, Outcome, shared_mark
from meshmark.research.benchmark.run.row import Case, Row
from meshmark.research.benchmark.run.suites import SUITES
from meshmark.research.schemes.scheme import SharedMark

__all__ = ["answered_blind", "blind_of", "outcome_of", "read_by_both"]

# Fields of a row that say what was read.
_READ = ("ber", "raw_ber", "correlation", "present", "decoded", "recovered", "log10_false_positive")
# The chance of being wrong is shared by two readings.
_HALF = log10(2.0)


def blind_of(job: Job, schemes: Iterable[str]) -> Case | None:
    """Return the case in which a blind scheme reads the same suspect, None where none of these schemes does.

    None as well in a suite that is made for the times of each scheme.
    """
    if not isinstance(job, Case) or SUITES[job.suite].fresh:
        return None
    shared = shared_mark(job.scheme)
    if shared is None or shared.scheme not in schemes:
        return None
    return replace(job, scheme=shared.scheme)


def outcome_of(row: Row) -> Outcome:
    """Return the outcome of a reading that a row was made of."""
    times = ("attack_seconds", "extract_seconds", "vertices_per_second", "attacked_psnr_db", "peak_mb")
    figures = {name: getattr(row, name) for name in (*_READ, *times)}
    return Outcome(status=row.status, note=row.note, figures=figures)


def answered_blind(scheme: str, blind: Outcome) -> Outcome | None:
    """Return the outcome for a scheme where the payload was decoded blind; None: its reference is to be asked."""
    shared = shared_mark(scheme)
    if shared is None or blind.status != "ok" or not blind.figures["decoded"]:
        return None
    halved = _halved(blind.figures, shared)
    return replace(blind, figures=halved) if halved["present"] else None


def read_by_both(scheme: str, told: Outcome, blind: Outcome) -> Outcome:
    """Return the outcome for a scheme from what its reference told and what was read blind."""
    shared = shared_mark(scheme)
    if shared is None or told.status != "ok":
        return told
    figures = _halved(told.figures, shared)
    if blind.status != "ok":
        return replace(told, figures=figures) if figures["present"] else blind
    if not figures["present"]:
        figures |= _halved({name: blind.figures[name] for name in _READ}, shared)
    points = told.figures["vertices_per_second"] * told.figures["extract_seconds"]
    seconds = told.figures["extract_seconds"] + blind.figures["extract_seconds"]
    peaks = [each.figures["peak_mb"] for each in (told, blind) if each.figures.get("peak_mb")]
    figures |= {
        "extract_seconds": seconds,
        "vertices_per_second": points / seconds,
        "peak_mb": max(peaks, default=None),
    }
    return replace(told, figures=figures)


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
        "decoded": present and bool(figures["decoded"]),
        "recovered": present and bool(figures["recovered"]),
    }

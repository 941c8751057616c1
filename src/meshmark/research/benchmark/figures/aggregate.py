"""From rows to figures: how often a mark is found, how often one is found that is not there.

A row whose case was refused, failed, ran out of time or was killed counts as a miss in every rate of `Robustness`,
and is counted there by its status too. Bit errors can only be counted where something was read.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.research.benchmark.figures.intervals import (
    Estimate,
    mean,
    per_model,
    rate,
    rate_by_model,
    upper_limit,
)
from meshmark.research.benchmark.figures.labels import order
from meshmark.research.benchmark.run.model_files import SIZE_CLASSES
from meshmark.research.benchmark.run.row import Row

__all__ = [
    "ALL",
    "Alarms",
    "Robustness",
    "alarms",
    "groups",
    "main_split",
    "marked",
    "robustness",
    "size_classes",
]

ALL = "all"
_SIZES = [name for _, name in SIZE_CLASSES]
_BROKEN = ("failed", "timeout", "killed")
# Trials in which nothing should be found.
_EMPTY = ("unmarked", "wrong key", "forged")


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """How a scheme at a budget fares under an attack, over the models of a split and a size class.

    trials, models: how many. refused, broken: trials that ended so, misses in `present` and `recovered`.
    present_where_read, recovered_where_read: the same rates over the trials that were read.
    ber, raw_ber: means over models of those read; correlation likewise.
    """

    scheme: str
    budget: str
    attack: str
    split: str
    size_class: str
    trials: int
    models: int
    refused: int
    broken: int
    present: Estimate
    recovered: Estimate
    present_where_read: Estimate | None
    recovered_where_read: Estimate | None
    ber: Estimate | None
    raw_ber: Estimate | None
    correlation: float | None


@dataclass(frozen=True, kw_only=True)
class Alarms:
    """What a scheme finds where there is nothing to find.

    trials: those that were read; not_read: the others. found: how often the scheme said "present";
    limit: the rate that is exceeded with at most 5 % confidence. ber: of what was read against the payload.
    least: the smallest log10 of a false-positive bound seen.
    """

    scheme: str
    trial: str
    size_class: str
    trials: int
    not_read: int
    found: int
    rate: Estimate | None
    limit: float
    ber: Estimate | None
    least: float | None


def groups(rows: Iterable[Row], *names: str) -> dict[tuple[str, ...], list[Row]]:
    """Return rows by the values of fields of their case or of their own, sorted by those values."""
    found: dict[tuple[str, ...], list[Row]] = defaultdict(list)
    for row in rows:
        found[tuple(str(getattr(row.case, name, None) or getattr(row, name, "")) for name in names)].append(
            row
        )
    return dict(sorted(found.items()))


def marked(rows: Iterable[Row]) -> list[Row]:
    """Return the rows in which the mark should be found."""
    return [row for row in rows if row.case.trial == "marked"]


def main_split(rows: Sequence[Row]) -> str:
    """Return the split that results are quoted for: "test" where both are there, else all rows."""
    return "test" if {"train", "test"} <= {row.split for row in rows} else ALL


def size_classes(rows: Iterable[Row]) -> list[str]:
    """Return the size classes that occur, smallest first."""
    found = {row.size_class for row in rows if row.size_class}
    return [name for name in _SIZES if name in found] + sorted(found - set(_SIZES))


def robustness(rows: Sequence[Row]) -> list[Robustness]:
    """Return one entry for each scheme, budget, attack, split and size class that has a marked trial.

    Splits are told apart where both exist; split and size class "all" hold everything.
    """
    result, splits = [], _splits(rows)
    for (scheme, budget, attack), cases in groups(marked(rows), "scheme", "budget", "attack").items():
        for split, size, part in _parts(cases, splits):
            result.append(_robustness(scheme, budget, attack, split, size, part))
    return sorted(result, key=lambda r: (r.scheme, r.budget, order(r.attack)))


def alarms(rows: Sequence[Row]) -> list[Alarms]:
    """Return one entry for each scheme, kind of trial without a mark, and size class ("all" first)."""
    result = []
    empty = [row for row in rows if row.case.trial in _EMPTY]
    for (scheme, trial), cases in groups(empty, "scheme", "trial").items():
        for _, size, part in _parts(cases, [ALL]):
            result.append(_alarms(scheme, trial, size, part))
    return sorted(result, key=lambda a: (a.scheme, _EMPTY.index(a.trial)))


def _splits(rows: Sequence[Row]) -> list[str]:
    return [ALL] if main_split(rows) == ALL else [ALL, "test", "train"]


def _parts(rows: Sequence[Row], splits: Sequence[str]) -> Iterator[tuple[str, str, list[Row]]]:
    """Yield (split, size class, rows), "all" first."""
    for split in splits:
        for size in (ALL, *size_classes(rows)):
            part = [row for row in rows if split in (ALL, row.split) and size in (ALL, row.size_class)]
            if part:
                yield split, size, part


def _robustness(scheme: str, budget: str, attack: str, split: str, size: str, rows: list[Row]) -> Robustness:
    models = [row.case.model for row in rows]
    read = [row for row in rows if row.status == "ok"]
    present, recovered = _rate(rows, "present"), _rate(rows, "recovered")
    if present is None or recovered is None:  # never: a group has rows
        raise ValueError("a group without rows")
    correlation = _mean(read, "correlation", (-1.0, 1.0))
    return Robustness(
        scheme=scheme,
        budget=budget,
        attack=attack,
        split=split,
        size_class=size,
        trials=len(rows),
        models=len(set(models)),
        refused=sum(row.status == "refused" for row in rows),
        broken=sum(row.status in _BROKEN for row in rows),
        present=present,
        recovered=recovered,
        present_where_read=_rate(read, "present"),
        recovered_where_read=_rate(read, "recovered"),
        ber=_mean(read, "ber"),
        raw_ber=_mean(read, "raw_ber"),
        correlation=None if correlation is None else correlation.value,
    )


def _alarms(scheme: str, trial: str, size: str, rows: list[Row]) -> Alarms:
    read = [row for row in rows if row.status == "ok" and row.present is not None]
    found = sum(bool(row.present) for row in read)
    bounds = [row.log10_false_positive for row in read if row.log10_false_positive is not None]
    return Alarms(
        scheme=scheme,
        trial=trial,
        size_class=size,
        trials=len(read),
        not_read=len(rows) - len(read),
        found=found,
        rate=rate(found, len(read)),
        limit=upper_limit(found, len(read)),
        ber=mean([row.ber for row in read if row.ber is not None]),  # each trial has a key of its own
        least=min(bounds, default=None),
    )


def _rate(rows: Sequence[Row], field: str) -> Estimate | None:
    hits = [row.status == "ok" and bool(getattr(row, field)) for row in rows]
    return rate_by_model(hits, [row.case.model for row in rows])


def _mean(rows: Sequence[Row], field: str, limits: tuple[float, float] = (0.0, 1.0)) -> Estimate | None:
    having = [(row.case.model, getattr(row, field)) for row in rows]
    known = [(model, value) for model, value in having if value is not None and np.isfinite(value)]
    return mean(per_model([value for _, value in known], [model for model, _ in known]), limits)

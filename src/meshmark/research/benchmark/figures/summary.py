"""The short table that a run ends with: one line for each scheme, budget, trial and attack."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from meshmark.research.benchmark.figures.labels import ordered
from meshmark.research.benchmark.run.row import TRIALS, Row

__all__ = ["Line", "as_table", "summary"]


@dataclass(frozen=True, kw_only=True)
class Line:
    """Some cases that differ only in model and repeat.

    cases: all of them; refused, failed: those without a figure because the scheme refused the model, or because
    something broke. present, recovered: how many of all cases said so. ber: mean over those read; None for none.
    """

    scheme: str
    budget: str
    trial: str
    attack: str
    cases: int
    refused: int
    failed: int
    present: int
    recovered: int
    ber: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return asdict(self)


def summary(rows: Iterable[Row]) -> list[Line]:
    """Return the lines by scheme, budget, trial and attack, attacks by kind and mildest first."""
    groups: dict[tuple[str, str, str, str], list[Row]] = {}
    for row in rows:
        case = row.case
        groups.setdefault((case.scheme, case.budget, case.trial, case.attack), []).append(row)
    place = {attack: number for number, attack in enumerate(ordered({attack for *_, attack in groups}))}
    trials = list(TRIALS)
    names = sorted(groups, key=lambda each: (*each[:2], trials.index(each[2]), place[each[3]]))
    return [_line(*each, groups[each]) for each in names]


def _line(scheme: str, budget: str, trial: str, attack: str, group: Sequence[Row]) -> Line:
    bers = [row.ber for row in group if row.ber is not None]
    refused = sum(row.status == "refused" for row in group)
    return Line(
        scheme=scheme,
        budget=budget,
        trial=trial,
        attack=attack,
        cases=len(group),
        refused=refused,
        failed=sum(row.status != "ok" for row in group) - refused,
        present=sum(row.present is True for row in group),
        recovered=sum(row.recovered is True for row in group),
        ber=sum(bers) / len(bers) if bers else None,
    )


def as_table(lines: Iterable[Line]) -> list[str]:
    """Return the lines as text, in columns."""
    head = (
        "scheme",
        "budget",
        "trial",
        "attack",
        "cases",
        "refused",
        "failed",
        "present",
        "recovered",
        "BER",
    )
    body = [head, *(_cells(line) for line in lines)]
    widths = [max(map(len, column)) for column in zip(*body, strict=True)]
    words = 4  # the columns of words stand left, those of numbers right
    return [
        "  ".join(
            cell.ljust(width) if i < words else cell.rjust(width) for i, (cell, width) in enumerate(cells)
        )
        for cells in (list(zip(row, widths, strict=True)) for row in body)
    ]


def _cells(line: Line) -> tuple[str, ...]:
    counts = (line.cases, line.refused, line.failed)
    rates = (f"{100 * count / line.cases:.1f} %" for count in (line.present, line.recovered))
    ber = "-" if line.ber is None else f"{100 * line.ber:.1f} %"
    return (line.scheme, line.budget, line.trial, line.attack, *map(str, counts), *rates, ber)

"""The words of a report explained: measures, attacks, schemes."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.attacks.table import ATTACKS
from meshmark.metrics import METRICS
from meshmark.research.benchmark.figures.labels import family_label, order, steps
from meshmark.research.benchmark.page.report_parts import Cell, Section, Table
from meshmark.research.benchmark.page.tables import MEASURE_LABELS
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.row import STATUSES, TRIALS, Row

__all__ = ["glossary"]

# Measures of a reading; those between two models are explained by `METRICS`.
_READINGS = {
    "mark found": "the scheme says that a mark of this key is there, at the false-positive rate it decides at",
    "id exact": "the mark is found and every bit of the payload is right",
    "bit errors": "share of wrong payload bits (BER): 0 % perfect, 50 % guessing",
    "raw bit errors": "the same for the carriers, before error correction",
    "correlation": "between payload and reading, bits as −1 and 1: 1 perfect, 0 guessing",
    "smallest p": "a scheme's own bound on the chance of finding a mark where there is none",
    "growth": "g of seconds ~ points^g",
}


def glossary(rows: Sequence[Row], facts: Facts) -> Section:
    """Return tables of the measures, the attacks that occur, the kinds of trial and the schemes."""
    measures = [*_READINGS.items(), *_between_models()]
    tables = [
        _table("Measures", ("measure", "meaning"), measures),
        _table("Attacks", ("attack", "imitates", "strength counts"), _attacks(rows)),
        _table(
            "Trials", ("trial", "what it is"), [(n, TRIALS[n]) for n in _seen(rows, "trial") if n in TRIALS]
        ),
        _table("Outcomes", ("outcome", "meaning"), [(name, _OUTCOMES[name]) for name in STATUSES]),
        _table("Schemes", ("scheme", "title and source"), list(facts.schemes.items())),
    ]
    return Section(
        name="words", title="Words", words=(), parts=tuple(table for table in tables if table.rows)
    )


_OUTCOMES = {
    "ok": "measured",
    "refused": "the scheme says that the model cannot carry the mark",
    "failed": "an error, with its sentence",
    "timeout": "took longer than the time limit",
    "killed": "the worker died, most often for lack of memory",
}


def _between_models() -> list[tuple[str, str]]:
    result = []
    for name, metric in METRICS.items():
        ends = f"{metric.better} is better"
        result.append((MEASURE_LABELS.get(name, name), f"{metric.meaning} ({metric.unit}; {ends})"))
    return result


def _attacks(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    names = {name for row in rows for name, _ in steps(row.case.attack)}
    known = sorted((name for name in names if name in ATTACKS), key=order)
    return [(family_label(name), ATTACKS[name].imitates, ATTACKS[name].unit) for name in known]


def _seen(rows: Sequence[Row], field: str) -> list[str]:
    return sorted({getattr(row.case, field) for row in rows})


def _table(title: str, columns: tuple[str, ...], lines: Sequence[tuple[str, ...]]) -> Table:
    return Table(
        title=title,
        columns=columns,
        rows=tuple(tuple(Cell(text=text) for text in line) for line in lines),
        folded=True,
    )

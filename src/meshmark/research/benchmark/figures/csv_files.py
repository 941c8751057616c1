"""The rows and their summary as CSV, for a spreadsheet or another program."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from typing import Any, get_type_hints

from meshmark.research.benchmark.figures.aggregate import Robustness
from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.run.row import Case, Row

__all__ = ["read_results", "results_csv", "summary_csv"]

_CASE = [field.name for field in fields(Case)]
_ROW = [field.name for field in fields(Row) if field.name != "case"]
_ESTIMATES = ("present", "recovered", "present_where_read", "recovered_where_read", "ber", "raw_ber")


def results_csv(rows: Iterable[Row]) -> str:
    """Return all rows, one line each, sorted by case; nothing where a figure is None, true or false as 1 or 0."""
    lines = ({**asdict(row.case), **{name: getattr(row, name) for name in _ROW}} for row in rows)
    ordered = sorted(lines, key=lambda line: [line[name] for name in _CASE])
    return _text([*_CASE, *_ROW], ([_plain(line[name]) for name in (*_CASE, *_ROW)] for line in ordered))


def read_results(text: str) -> list[Row]:
    """Return the rows of a `results.csv`, exactly as they were written."""
    kinds = {**get_type_hints(Case), **get_type_hints(Row)}
    rows = []
    for line in csv.DictReader(io.StringIO(text)):
        values = {name: _value(line[name], kinds[name]) for name in (*_CASE, *_ROW)}
        case = Case(**{name: values.pop(name) for name in _CASE})
        rows.append(Row(case=case, **values))
    return rows


def summary_csv(figures: Sequence[Robustness]) -> str:
    """Return the figures of each scheme, budget, attack, split and size class, rates with their intervals."""
    names = [field.name for field in fields(Robustness)]
    columns = [column for name in names for column in _columns(name)]
    return _text(columns, ([_plain(v) for name in names for v in _cells(item, name)] for item in figures))


def _columns(name: str) -> list[str]:
    return [name, f"{name}_low", f"{name}_high"] if name in _ESTIMATES else [name]


def _cells(item: Robustness, name: str) -> list[Any]:
    value = getattr(item, name)
    if name not in _ESTIMATES:
        return [value]
    return [value.value, value.low, value.high] if isinstance(value, Estimate) else [None, None, None]


def _plain(value: Any) -> Any:
    if value is None:
        return ""
    return int(value) if isinstance(value, bool) else value


def _value(text: str, kind: Any) -> Any:
    """Return a cell as the type of its field, which is str, int, or one of those with None."""
    if kind is str:
        return text
    if text == "":
        return None
    for plain in (bool, int, float):
        if kind in (plain, plain | None):
            return bool(int(text)) if plain is bool else plain(text)
    return text


def _text(columns: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(lines)
    return target.getvalue()

"""Figures 9 and 10: marks that are not found, and found, over growing numbers of models; with the false alarms."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from meshmark.research.benchmark.figures.intervals import Estimate, rate, rate_by_model, upper_limit
from meshmark.research.benchmark.figures.labels import NOTHING
from meshmark.research.benchmark.page.report_parts import Cell, Plot, Table, percent
from meshmark.research.benchmark.paper.line_plot import Line, entries, panel
from meshmark.research.benchmark.paper.measured import Measured, title_of
from meshmark.research.benchmark.paper.published_claims import CLAIMED, DOUBTS, FIGURES
from meshmark.research.benchmark.run.row import Row
from meshmark.research.benchmark.run.seeds import hashed

__all__ = ["rate_parts"]

COUNTS = (10, 25, 50, 100, 200, 363, 500)


def rate_parts(measured: Measured, *, pictures: bool) -> list[Table | Plot]:
    """Return figures 9 and 10 as tables, and as plots where `pictures`."""
    models = sorted({row.case.model for row in measured.rows}, key=hashed)
    counts = [count for count in COUNTS if count < len(models)] + [len(models)]
    parts: list[Table | Plot] = []
    for number, what, wanted, missed in _FIGURES:
        lines = [
            (
                title_of(name),
                [
                    (float(count), value)
                    for count in counts
                    if (value := _rate(measured, name, models[:count], wanted, missed))
                ],
            )
            for name in measured.schemes
        ]
        if pictures and any(points for _, points in lines):
            drawn = panel(
                f"paper-figure-{number}", f"Figure {number}", lines, across="models", up="%", least=None
            )
            parts.append(
                Plot(
                    title=f"Figure {number}: {what}", caption=_CAPTION, panels=(drawn,), legend=entries(lines)
                )
            )
        parts.append(_table(measured, number, what, lines, counts))
    return parts


def _attacked(row: Row) -> bool:
    return row.case.attack != NOTHING


def _any(_: Row) -> bool:
    return True


_FIGURES = (
    (9, "distortion rate: marks not found in attacked models", _attacked, True),
    (10, "true positive rate: marks found, untouched and attacked", _any, False),
)


def _rate(
    measured: Measured, scheme: str, models: Sequence[str], wanted: Callable[[Row], bool], missed: bool
) -> Estimate | None:
    chosen = set(models)
    rows = [
        row
        for row in measured.rows
        if row.case.scheme == scheme and row.case.trial == "marked" and row.case.model in chosen
        and row.status != "refused" and wanted(row)
    ]  # fmt: skip
    hits = [(row.status == "ok" and bool(row.present)) != missed for row in rows]
    found = rate_by_model(hits, [row.case.model for row in rows])
    return found and Estimate(
        100 * found.value, 100 * found.low, 100 * found.high, len({r.case.model for r in rows})
    )


def _table(measured: Measured, number: int, what: str, lines: Sequence[Line], counts: Sequence[int]) -> Table:
    claims = dict(zip(CLAIMED, FIGURES[number][1], strict=True))
    columns = ("models", *(title for title, _ in lines))
    claimed = tuple(
        Cell(text=f"{claims[name]:g} %") if name in claims else Cell(text="–") for name in measured.schemes
    )
    rows = [(Cell(text="claimed"), *claimed)]
    for count in counts:
        at = [dict(points).get(float(count)) for _, points in lines]
        rows.append((Cell(text=f"first {count}"), *(_cell(value) for value in at)))
    if number == 10:
        rows.append(
            (Cell(text="false positive rate"), *(_alarm(measured, name) for name in measured.schemes))
        )
    return Table(
        title=f"Figure {number}: {what}",
        columns=columns,
        rows=tuple(rows),
        note=f"{_CAPTION} Doubts: {DOUBTS[f'Figure {number}']}",
    )


def _cell(value: Estimate | None) -> Cell:
    if value is None:
        return Cell(text="–")
    return Cell(text=f"{value.value:.1f} %", small=f"{value.low:.0f}–{value.high:.0f} %, n {value.count}")


def _alarm(measured: Measured, scheme: str) -> Cell:
    empty = ("unmarked", "wrong key")
    rows = [
        r for r in measured.rows if r.case.scheme == scheme and r.case.trial in empty and r.status == "ok"
    ]
    found = sum(bool(row.present) for row in rows)
    value = rate(found, len(rows))
    return Cell(text="–") if value is None else Cell(
        text=percent(value.value), small=f"{found} of {len(rows)}, at most {percent(upper_limit(found, len(rows)))}"
    )  # fmt: skip


_CAPTION = (
    "Over the first n models in an order drawn by a hash, n counting those that the scheme could mark; "
    "all of the paper's attacks alike; 95 % intervals that count models. A rate that grows with the number "
    "of models would be an error of counting."
)

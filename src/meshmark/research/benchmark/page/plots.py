"""The plots of a report, by the section they belong to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from meshmark.research.benchmark.figures.aggregate import (
    ALL,
    Robustness,
    main_split,
    robustness,
    size_classes,
)
from meshmark.research.benchmark.page.calibration import calibration_plot
from meshmark.research.benchmark.page.curves import Series, curve_plot, dot_plot
from meshmark.research.benchmark.page.drawing import COLOURS, DASHES
from meshmark.research.benchmark.page.mark_plots import distortion_plot, time_plot
from meshmark.research.benchmark.page.report_parts import Entry, Plot
from meshmark.research.benchmark.run.row import Row

__all__ = ["plots"]


def plots(rows: Sequence[Row]) -> dict[str, list[Plot]]:
    """Return the plots of each section; a section without figures has none. Needs matplotlib."""
    figures = [figure for figure in robustness(rows) if figure.split == main_split(rows)]
    return {
        "attacks": _robust(figures, size_classes(rows)),
        "alarms": _some(calibration_plot(rows)),
        "distortion": _some(distortion_plot(rows)),
        "speed": _some(time_plot(rows)),
    }


def _robust(figures: Sequence[Robustness], sizes: Sequence[str]) -> list[Plot]:
    by_mark = _by_mark([figure for figure in figures if figure.size_class == ALL])
    found = []
    for name, title, series in _together(by_mark):
        found += _some(
            curve_plot(f"ber{name}", f"Bit errors against strength{title}", _BER, series, "ber"),
            curve_plot(f"exact{name}", f"Id exact against strength{title}", _RATE, series, "recovered"),
            curve_plot(f"found{name}", f"Mark found against strength{title}", _FOUND, series, "present"),
            dot_plot(
                f"single{name}", f"Attacks of one strength, and chains{title}", _DOTS, series, "recovered"
            ),
        )
    for number, one in enumerate(by_mark, 1):
        scheme, budget = one.figures[0].scheme, one.figures[0].budget
        mine = [f for f in figures if (f.scheme, f.budget) == (scheme, budget)]
        by_size = _by_size(mine, sizes)
        if len(by_size) > 1:
            for field, words in (("ber", "bit errors"), ("recovered", "id exact")):
                title = f"{scheme}, {budget}: {words} by size of the model"
                plot = curve_plot(f"{field}-by-size-{number}", title, _SIZES, by_size, field)
                found += [] if plot is None else [replace(plot, folded=True)]
    return found


def _together(by_mark: Sequence[Series]) -> list[tuple[str, str, list[Series]]]:
    """Return (end of names, end of titles, series) of what shares panels: with several schemes, one budget."""
    budgets = list(dict.fromkeys(one.figures[0].budget for one in by_mark))
    if len(by_mark) == len(budgets) or len(budgets) == 1:
        return [("", "", list(by_mark))] if by_mark else []
    return [
        (f"-{budget}", f", {budget}", [one for one in by_mark if one.figures[0].budget == budget])
        for budget in budgets
    ]


def _by_mark(figures: Sequence[Robustness]) -> list[Series]:
    """Return a series for each scheme and budget: colours tell schemes, or budgets where there is one scheme."""
    keys = list(dict.fromkeys((f.scheme, f.budget) for f in figures))
    schemes, budgets = (list(dict.fromkeys(key[i] for key in keys)) for i in (0, 1))
    series = []
    for scheme, budget in keys:
        own = schemes.index(scheme) if len(schemes) > 1 else budgets.index(budget)
        entry = Entry(
            words=f"{scheme}, {budget}", colour=own % len(COLOURS), dash=budgets.index(budget) % len(DASHES)
        )
        series.append(Series(entry, tuple(f for f in figures if (f.scheme, f.budget) == (scheme, budget))))
    return series


def _by_size(figures: Sequence[Robustness], sizes: Sequence[str]) -> list[Series]:
    series = []
    for i, size in enumerate(sizes):
        chosen = tuple(figure for figure in figures if figure.size_class == size)
        if chosen:
            models = max(figure.models for figure in chosen)
            series.append(
                Series(Entry(words=f"{size} points (n = {models})", colour=i % len(COLOURS)), chosen)
            )
    return series


def _some(*plots: Plot | None) -> list[Plot]:
    return [plot for plot in plots if plot is not None]


_AXES = (
    "Strengths stand at their true distances; where they span more than a factor of 12, the axis is linear near 0 "
    "and logarithmic beyond."
)
_BER = (
    "Mean share of wrong bits over the models read, with its 95 % interval; the dashed line at 50 % is guessing, "
    f"and what reaches beyond 65 % is cut. {_AXES}"
)
_RATE = (
    "Share of marked models whose id came back without an error, with its 95 % interval; refused and failed cases "
    "are misses."
)
_FOUND = (
    "Share of marked models in which the scheme says its mark is there, at the false-positive rate it decides at "
    "(see “False alarms”), with its 95 % interval; refused and failed cases are misses."
)
_DOTS = "Share of marked models whose id came back without an error; lines are 95 % intervals."
_SIZES = "The same for each size class; bands are 95 % intervals and wide where a class has few models."

"""Plots of what marks change and of the time they take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from meshmark.research.benchmark.figures.aggregate import groups, size_classes
from meshmark.research.benchmark.figures.distortion import marks
from meshmark.research.benchmark.figures.speed import Timing, growth, timings
from meshmark.research.benchmark.page.drawing import COLOURS, DASHES, INK, MARKERS, draw
from meshmark.research.benchmark.page.report_parts import Entry, Panel, Plot, number
from meshmark.research.benchmark.run.row import Row
from meshmark.strengths import BUDGETS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["distortion_plot", "time_plot"]

_MEASURES = {
    "rms_over_diagonal": ("RMS change, % of the diagonal", 100.0),
    "msdm2": ("MSDM2 (0 same, 1 unlike)", 1.0),
}


def distortion_plot(rows: Sequence[Row]) -> Plot | None:
    """Return the change of each marked model by size class, a panel for each budget and measure."""
    made = marks(rows)
    schemes = sorted({row.case.scheme for row in made})
    panels = []
    for (budget,), part in groups(made, "budget").items():
        for measure in _MEASURES:
            if any(getattr(row, measure) is not None for row in part):
                panels.append(_strips(budget, measure, part, schemes))
    if not panels:
        return None
    entries = tuple(Entry(words=scheme, colour=i % len(COLOURS)) for i, scheme in enumerate(schemes))
    return Plot(
        title="How far the marks move the surface", caption=_STRIPS, panels=tuple(panels), legend=entries
    )


def _strips(budget: str, measure: str, rows: Sequence[Row], schemes: Sequence[str]) -> Panel:
    words, unit = _MEASURES[measure]
    sizes = size_classes(rows)
    step = 0.8 / len(schemes)
    limit = BUDGETS.get(budget) if measure == "rms_over_diagonal" else None

    def values(scheme: str, size: str) -> list[float]:
        chosen = [row for row in rows if (row.case.scheme, row.size_class) == (scheme, size)]
        return sorted(unit * value for row in chosen if (value := getattr(row, measure)) is not None)

    def paint(axes: Axes) -> None:
        for i, scheme in enumerate(schemes):
            for at, size in enumerate(sizes):
                _strip(axes, values(scheme, size), at + step * (i - (len(schemes) - 1) / 2), step, i)
        if limit is not None:
            axes.axvline(unit * limit, color=INK, lw=1, ls=DASHES[1])
            axes.text(unit * limit, -0.62, "budget ", ha="right", va="top", fontsize=7)
        axes.set_yticks(range(len(sizes)), sizes)
        axes.set_ylim(len(sizes) - 0.4, -0.7)
        axes.set_xlim(left=0.0)
        axes.set_xlabel(words)
        axes.set_title(budget)

    said = "; ".join(
        f"{scheme}, {size} points: median {number(float(np.median(found)))}, largest {number(found[-1])}"
        for scheme in schemes
        for size in sizes
        if (found := values(scheme, size))
    )
    named = measure.split("_")[0]
    height = 1.0 + 0.28 * len(sizes) * max(1.0, 0.4 * len(schemes))
    return draw(
        f"distortion-{budget}-{named}",
        f"{words}, {budget} budget: {said}",
        paint,
        height=height,
        words=[*sizes, "points"],
    )


def _strip(axes: Axes, values: list[float], y: float, step: float, series: int) -> None:
    """Draw the values as dots, spread a little, over a box from quarter to quarter with the median."""
    if not values:
        return
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    axes.barh(y, high - low, 0.7 * step, low, color=COLOURS[series % len(COLOURS)], alpha=0.22, lw=0)
    spread = 0.4 * step * (np.arange(len(values)) % 5 - 2) / 2
    axes.plot(
        values,
        y + spread,
        MARKERS[series % len(MARKERS)],
        ms=2.8,
        color=COLOURS[series % len(COLOURS)],
        alpha=0.75,
    )
    axes.vlines(middle, y - 0.35 * step, y + 0.35 * step, INK, lw=1.4)


def time_plot(rows: Sequence[Row]) -> Plot | None:
    """Return seconds against points, both logarithmic, for embedding and extraction, with the slopes."""
    series = groups_of_timings(timings(rows))
    if not series:
        return None
    schemes, budgets = (list(dict.fromkeys(key[i] for key in series)) for i in (0, 1))
    several = len(schemes) > 1
    entries = {
        key: Entry(
            words=f"{key[0]}, {key[1]}",
            colour=(schemes.index(key[0]) if several else budgets.index(key[1])) % len(COLOURS),
            dash=budgets.index(key[1]) % len(DASHES),
        )
        for key in series
    }
    panels = [_times(field, words, series, entries) for field, words in _TIMES.items()]
    return Plot(
        title="Time against the size of the model",
        caption=_GROWTH,
        panels=tuple(panels),
        legend=tuple(entries.values()),
    )


_TIMES = {"embed": "embedding", "extract": "extraction"}


def groups_of_timings(timed: Sequence[Timing]) -> dict[tuple[str, str], list[Timing]]:
    """Return times by scheme and budget."""
    found: dict[tuple[str, str], list[Timing]] = {}
    for timing in timed:
        found.setdefault((timing.scheme, timing.budget), []).append(timing)
    return found


def _times(
    field: str,
    words: str,
    series: dict[tuple[str, str], list[Timing]],
    entries: dict[tuple[str, str], Entry],
) -> Panel:
    slopes = {}
    for key, timed in series.items():
        slopes[key] = growth([t.points for t in timed], [getattr(t, field) for t in timed])

    def paint(axes: Axes) -> None:
        for key, timed in series.items():
            pairs = sorted((t.points, s) for t in timed if (s := getattr(t, field)))
            if pairs:
                _cloud(axes, pairs, slopes[key], entries[key])
        axes.set(xscale="log", yscale="log", xlabel="points of the model", ylabel="seconds, median")
        _plain_numbers(axes)
        axes.set_title(words)

    said = "; ".join(f"{entries[key].words}: slope {number(slope, 2)}" for key, slope in slopes.items())
    return draw(f"time-{field}", f"Seconds of {words} against points: {said}", paint, words=["10^-1 sec"])


def _plain_numbers(axes: Axes) -> None:
    """Name 1, 2 and 5 (1 and 3, or 1 alone, on a long axis) of each decade, without powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        decades = np.log10(high / low)
        digits = (1.0, 2.0, 5.0) if decades < 1.2 else (1.0, 3.0) if decades < 2.6 else (1.0,)
        axis.set_major_locator(LogLocator(subs=digits, numticks=20))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))


def _cloud(axes: Axes, pairs: list[tuple[int, float]], slope: float | None, entry: Entry) -> None:
    x, y = np.asarray(pairs, float).T
    colour = COLOURS[entry.colour]
    axes.plot(x, y, MARKERS[entry.colour], ms=3.5, color=colour, alpha=0.8)
    if slope is None:
        return
    centre = np.exp(np.mean(np.log(y)) - slope * np.mean(np.log(x)))
    ends = x[[0, -1]]
    axes.plot(ends, centre * ends**slope, color=colour, lw=1.2, ls=DASHES[entry.dash])
    axes.annotate(
        f"slope {number(slope, 2)}", (ends[1], centre * ends[1] ** slope), (-2, 4), textcoords="offset points",
        ha="right", fontsize=7, color=INK,
    )  # fmt: skip


_STRIPS = (
    "Every dot is a marked model; boxes reach from quarter to quarter, with the median. The dashed line is the "
    "budget: the root mean square of the displacements may not exceed it."
)
_GROWTH = "Both axes are logarithmic: slope 1 is twice the time for twice the points. Dots are models."

"""A plot of a few lines with their intervals, for the paper's figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.page.drawing import COLOURS, MARKERS, draw
from meshmark.research.benchmark.page.report_parts import Entry, Panel, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Line", "entries", "panel"]

# Name of the line, then places and values with their intervals.
Line = tuple[str, Sequence[tuple[float, Estimate]]]


def entries(lines: Sequence[Line]) -> tuple[Entry, ...]:
    """Return the legend of lines."""
    return tuple(Entry(words=name, colour=i % len(COLOURS)) for i, (name, _) in enumerate(lines))


def panel(
    name: str,
    title: str,
    lines: Sequence[Line],
    *,
    across: str,
    up: str,
    log: str = "",
    least: float | None = 0.0,
) -> Panel:
    """Return a picture of lines. across, up: what the axes show; log: those that are logarithmic, of "xy".

    least: where the upright axis begins; None leaves that to the values.
    """

    def paint(axes: Axes) -> None:
        for entry, (_, points) in zip(entries(lines), lines, strict=True):
            colour, x = COLOURS[entry.colour], [at for at, _ in points]
            low, high = [v.low for _, v in points], [v.high for _, v in points]
            axes.fill_between(x, low, high, color=colour, alpha=0.13, lw=0)
            values = [v.value for _, v in points]
            axes.plot(x, values, color=colour, marker=MARKERS[entry.colour], ms=3.5, lw=1.5)
        if "x" in log:
            axes.set_xscale("log")
        if "y" in log:
            axes.set_yscale("log")
        elif least is not None:
            axes.set_ylim(bottom=least)
        axes.set_xlabel(across)
        axes.set_title(f"{title}, {up}")

    said = "; ".join(
        f"{line}: " + ", ".join(f"{number(at)}: {number(value.value)}" for at, value in points)
        for line, points in lines
    )
    return draw(name, f"{title}, {up}, against {across}. {said}", paint, words=["0.0001"])

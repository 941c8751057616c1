"""The parts of a report, before they become Markdown or HTML: sections of tables, plots and words."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

from meshmark.research.benchmark.figures.intervals import Estimate

__all__ = ["Cell", "Entry", "Panel", "Plot", "Section", "Table", "estimate", "number", "percent"]

NOTHING = "–"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """What stands in a table: text, a smaller second text, and 0 (bad) to 1 (good) to colour it by."""

    text: str
    small: str = ""
    heat: float | None = None


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; its first column names the rows. note: how to read it. folded: shown when asked for."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    folded: bool = False


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One picture of a plot: a name for its file, what it shows in one sentence, and the SVG."""

    name: str
    alt: str
    svg: str


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A line of a legend: the words, the numbers of its colour and of its dashes (0 solid)."""

    words: str
    colour: int
    dash: int = 0


@dataclass(frozen=True, kw_only=True)
class Plot:
    """Pictures with one legend and one caption."""

    title: str
    caption: str
    panels: tuple[Panel, ...]
    legend: tuple[Entry, ...] = ()
    folded: bool = False


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the report. words: paragraphs before the tables and plots."""

    name: str
    title: str
    words: tuple[str, ...] = ()
    parts: tuple[Table | Plot, ...] = field(default=())


def percent(value: float | None, digits: int = 1) -> str:
    """Return a share as "93.3 %", without needless zeros; a dash for None."""
    if value is None:
        return NOTHING
    text = f"{100 * value:.{digits}f}"
    return f"{text.rstrip('0').rstrip('.') if '.' in text else text} %"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with this number of significant digits and no exponent where it can do without."""
    if value is None:
        return NOTHING
    if not isfinite(value):
        return "∞" if value > 0 else "−∞"
    if abs(value) >= 10**digits:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}".replace("-", "−", 1)


def estimate(value: Estimate | None, *, good: str = "high") -> Cell:
    """Return a rate with its interval; `good` says which end is, "" leaves the cell without colour."""
    if value is None:
        return Cell(text=NOTHING)
    interval = f"{percent(value.low, 0)[:-2]}–{percent(value.high, 0)}"
    heat = {"high": value.value, "low": max(0.0, 1.0 - 2.0 * value.value)}.get(good)
    return Cell(text=percent(value.value), small=interval, heat=heat)

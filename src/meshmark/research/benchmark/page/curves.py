"""Plots of rates and bit errors against the strength of an attack."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import asinh
from typing import TYPE_CHECKING

import numpy as np

from meshmark.attacks.table import ATTACKS
from meshmark.research.benchmark.figures.aggregate import Robustness
from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.figures.labels import (
    NOTHING,
    family,
    family_label,
    label,
    ordered,
    steps,
    strength_label,
)
from meshmark.research.benchmark.page.drawing import COLOURS, DASHES, MARKERS, SOFT, draw
from meshmark.research.benchmark.page.report_parts import Entry, Panel, Plot, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Series", "curve_plot", "dot_plot"]

# A strength axis over a wider range is drawn by asinh: near 0 linear, then logarithmic, and 0 has a place.
_LINEAR_UP_TO = 12.0
_TICK_GAP = 0.11
_MEASURES = {"ber": ("bit errors", 0.65), "present": ("mark found", 1.0), "recovered": ("id exact", 1.0)}


@dataclass(frozen=True)
class Series:
    """Figures that one line joins, and its entry in the legend."""

    entry: Entry
    figures: tuple[Robustness, ...]


def curve_plot(name: str, title: str, caption: str, series: Sequence[Series], field: str) -> Plot | None:
    """Return a plot with a panel for each kind of attack that has several strengths; None where there is none.

    field: "ber", "present" or "recovered" of `Robustness`, drawn with its interval as a band.
    """
    panels = []
    for kind in _kinds(series):
        panel = _curves(f"{name}-{kind.replace('_', '-')}", kind, series, field)
        panels += [] if panel is None else [panel]
    if not panels:
        return None
    return Plot(title=title, caption=caption, panels=tuple(panels), legend=tuple(one.entry for one in series))


def dot_plot(name: str, title: str, caption: str, series: Sequence[Series], field: str) -> Plot | None:
    """Return a plot with a line for each attack that `curve_plot` leaves out; None where there is none."""
    curves = _kinds(series)
    attacks = ordered({f.attack for one in series for f in one.figures if family(f.attack) not in curves})
    if not attacks:
        return None
    panel = _dots(name, attacks, series, field)
    return Plot(title=title, caption=caption, panels=(panel,), legend=tuple(one.entry for one in series))


def _kinds(series: Sequence[Series]) -> list[str]:
    strengths: dict[str, set[str]] = {}
    for attack in ordered({figure.attack for one in series for figure in one.figures}):
        kind = family(attack)
        if kind is not None:
            strengths.setdefault(kind, set()).add(attack)
    return [kind for kind, attacks in strengths.items() if len(attacks) > 1]


def _curves(name: str, kind: str, series: Sequence[Series], field: str) -> Panel | None:
    words, top = _MEASURES[field]
    lines = [(one.entry, _points(kind, one, field)) for one in series]
    strengths = sorted({x for _, points in lines for x, _ in points})
    if not strengths:
        return None
    place = _scale(kind, strengths)

    def paint(axes: Axes) -> None:
        for entry, points in lines:
            _line(axes, entry, [place(x) for x, _ in points], [y for _, y in points])
        _strength_axis(axes, kind, strengths, place)
        _percent_axis(axes, top)
        axes.set_title(family_label(kind))

    said = "; ".join(f"{entry.words} {_said(kind, points)}" for entry, points in lines if points)
    return draw(name, f"{words} against strength of {family_label(kind)}: {said}", paint)


def _points(kind: str, one: Series, field: str) -> list[tuple[float, Estimate]]:
    """Return strengths and estimates, with the untouched mark at 0 where 0 is the limit of the strengths."""
    points = []
    for figure in one.figures:
        value: Estimate | None = getattr(figure, field)
        if value is None:
            continue
        if figure.attack == NOTHING and _starts_at_zero(kind):
            points.append((0.0, value))
        elif family(figure.attack) == kind:
            points.append((steps(figure.attack)[0][1] or 0.0, value))
    if len(points) == 1 and points[0][0] == 0.0:
        return []
    return sorted(points, key=lambda point: point[0])


def _starts_at_zero(kind: str) -> bool:
    attack = ATTACKS.get(kind)
    return attack is None or attack.lowest == 0.0 or attack.unit.startswith(("passes", "levels"))


def _scale(kind: str, strengths: Sequence[float]) -> Callable[[float], float]:
    """Return where a strength stands: harm grows to the right."""
    attack = ATTACKS.get(kind)
    if attack is not None and attack.strengths[0] > attack.strengths[-1]:
        return lambda x: -x
    least = min((x for x in strengths if x > 0), default=1.0)
    if max(strengths) <= _LINEAR_UP_TO * least:
        return lambda x: x
    return lambda x: asinh(x / least)


def _strength_axis(
    axes: Axes, kind: str, strengths: Sequence[float], place: Callable[[float], float]
) -> None:
    at = sorted((place(x), x) for x in strengths)
    span = (at[-1][0] - at[0][0]) or 1.0
    kept: list[tuple[float, float]] = []
    for position, x in reversed(at):  # the strongest is always named
        if not kept or kept[-1][0] - position >= _TICK_GAP * span:
            kept.append((position, x))
    names = [strength_label(kind, x).removeprefix("× ").removesuffix(" bits") for _, x in kept]
    percents = all(name.endswith("%") for name in names)
    axes.set_xticks(
        [position for position, _ in kept],
        [name.removesuffix(" %") if percents and i else name for i, name in enumerate(names)],
    )
    axes.set_xlim(at[0][0] - 0.03 * span, at[-1][0] + 0.03 * span)
    axes.grid(False, axis="x")
    unit = ATTACKS[kind].unit if kind in ATTACKS else "strength"
    axes.set_xlabel(f"%, {unit}" if percents else unit, fontsize=7)


def _percent_axis(axes: Axes, top: float) -> None:
    ticks = [0.0, 0.25, 0.5] if top < 1.0 else [0.0, 0.25, 0.5, 0.75, 1.0]
    axes.set_ylim(-0.03 * top, 1.03 * top)
    axes.set_yticks(ticks, [percent(tick, 0) for tick in ticks])
    if top < 1.0:
        axes.axhline(0.5, color=SOFT, lw=0.8, ls=(0, (2, 2)))


def _line(axes: Axes, entry: Entry, x: list[float], y: list[Estimate]) -> None:
    colour = COLOURS[entry.colour]
    axes.fill_between(x, [v.low for v in y], [v.high for v in y], color=colour, alpha=0.13, lw=0)
    axes.plot(
        x,
        [v.value for v in y],
        color=colour,
        ls=DASHES[entry.dash],
        marker=MARKERS[entry.colour],
        ms=3.5,
        lw=1.5,
        clip_on=False,
    )


def _dots(name: str, attacks: Sequence[str], series: Sequence[Series], field: str) -> Panel:
    words, _ = _MEASURES[field]
    step = min(0.25, 0.7 / len(series))
    lines = [(one.entry, {f.attack: getattr(f, field) for f in one.figures}) for one in series]
    names = [label(attack).replace(" + ", " +\n") for attack in attacks]
    lines_of = np.array([1 + 0.6 * name.count("\n") for name in names])
    rows = np.cumsum(lines_of) - lines_of / 2

    def paint(axes: Axes) -> None:
        for i, (entry, values) in enumerate(lines):
            colour, shift = COLOURS[entry.colour], step * (i - (len(lines) - 1) / 2)
            known = [(y + shift, v) for y, a in zip(rows, attacks, strict=True) if (v := values.get(a))]
            axes.hlines(
                [y for y, _ in known], [v.low for _, v in known], [v.high for _, v in known], colour, lw=1
            )
            axes.plot(
                [v.value for _, v in known],
                [y for y, _ in known],
                MARKERS[entry.colour],
                color=colour,
                ms=4,
                clip_on=False,
            )
        axes.set_yticks(rows, names)
        axes.set_ylim(lines_of.sum(), 0.0)
        axes.set_xlim(0.0, 1.0)
        axes.set_xticks([0.0, 0.5, 1.0], ["0 %", "50 %", "100 %"])
        axes.set_title(words)

    said = "; ".join(
        f"{entry.words}: "
        + ", ".join(f"{label(a)} {percent(v.value)}" for a in attacks if (v := values.get(a)))
        for entry, values in lines
    )
    height = 0.75 + 0.2 * float(lines_of.sum()) * max(1.0, 0.45 * len(series))
    return draw(name, f"{words} under single attacks: {said}", paint, height=height, words=names)


def _said(kind: str, points: Sequence[tuple[float, Estimate]]) -> str:
    return ", ".join(f"{strength_label(kind, x) or f'{x:g}'}: {percent(y.value)}" for x, y in points)

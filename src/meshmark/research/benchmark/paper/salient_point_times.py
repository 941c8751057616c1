"""Figure 7: how long it takes to find salient points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.page.report_parts import Cell, Plot, Table, number
from meshmark.research.benchmark.paper.line_plot import entries, panel
from meshmark.research.benchmark.paper.published_claims import CLAIMED, DOUBTS, FIGURES
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.model_files import SIZE_CLASSES

__all__ = ["detection_parts"]

WAYS = {
    "nc_dgg": "NC-DGG",
    "laplace_beltrami": "Laplace–Beltrami",
    "adf": "auto diffusion",
    "random": "random vertices",
}
# A way's claim is that of the scheme it belongs to.
_SCHEME = {"nc_dgg": "ncdg_lv", "laplace_beltrami": "laplace_beltrami"}


def detection_parts(
    probes: Mapping[Probe, Outcome], sizes: Mapping[str, str], *, pictures: bool
) -> list[Table | Plot]:
    """Return figure 7; sizes: the size class of each model."""
    found = {p.model: o.figures for p, o in probes.items() if p.kind == "salient points" and o.status == "ok"}
    ways = [way for way in WAYS if any(way in figures for figures in found.values())]
    if not ways:
        return []
    order = [name for _, name in SIZE_CLASSES if name in {sizes.get(model) for model in found}]
    at = {
        (way, size): [
            1000.0 * f[way]["seconds"] for model, f in found.items() if sizes.get(model) == size and way in f
        ]
        for way in ways
        for size in order
    }
    least = {name: max(points, 100) for points, name in SIZE_CLASSES}
    lines = [
        (WAYS[way], [(float(least[size]), _middle(at[way, size])) for size in order if at[way, size]])
        for way in ways
    ]
    table = _table(ways, order, at, found)
    if not pictures:
        return [table]
    drawn = panel("paper-figure-7", "Figure 7", lines, across="points, from", up="ms", log="xy", least=None)
    return [
        Plot(
            title="Figure 7: salient point detection time",
            caption=_CAPTION,
            panels=(drawn,),
            legend=entries(lines),
        ),
        table,
    ]


def _middle(values: Sequence[float]) -> Estimate:
    low, middle, high = (float(np.quantile(values, q)) for q in (0.25, 0.5, 0.75))
    return Estimate(middle, low, high, len(values))


def _table(
    ways: Sequence[str],
    order: Sequence[str],
    at: Mapping[tuple[str, str], Sequence[float]],
    found: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> Table:
    claims = dict(zip(CLAIMED, FIGURES[7][1], strict=True))
    claimed = [claims.get(_SCHEME.get(way, "")) for way in ways]
    rows = [
        (Cell(text="claimed, first run"), *(Cell(text="–" if v is None else f"{v:g} ms") for v in claimed))
    ]
    for size in order:
        rows.append((Cell(text=f"{size} points"), *(_cell(at[way, size]) for way in ways)))
    totals = [sum(f[way]["seconds"] for f in found.values() if way in f) for way in ways]
    counts = [sum(way in f for f in found.values()) for way in ways]
    total = (Cell(text=f"{number(t)} s", small=f"{c} models") for t, c in zip(totals, counts, strict=True))
    rows.append((Cell(text="all together (eq. 16)"), *total))
    columns = ("models", *(WAYS[way] for way in ways))
    note = f"{_CAPTION} Doubts about the paper's figure 7: {DOUBTS['Figure 7']}"
    return Table(title="Figure 7: salient point detection time", columns=columns, rows=tuple(rows), note=note)


def _cell(milliseconds: Sequence[float]) -> Cell:
    if not milliseconds:
        return Cell(text="–")
    found = _middle(milliseconds)
    middle = f"{number(found.low)}–{number(found.high)}, n {found.count}"
    return Cell(text=f"{number(found.value)} ms", small=middle)


_CAPTION = (
    "Wall-clock on one thread, best of three; median over models and middle half; other work may run beside."
)

"""Whether false-positive bounds hold: claimed against observed, where there is nothing to find."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.research.benchmark.figures.aggregate import groups
from meshmark.research.benchmark.page.drawing import COLOURS, DASHES, INK, SOFT, draw
from meshmark.research.benchmark.page.report_parts import Entry, Panel, Plot, percent
from meshmark.research.benchmark.run.row import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["calibration_panel", "calibration_plot", "share_at_or_below"]

_TRIALS = ("unmarked", "wrong key")


def calibration_plot(rows: Sequence[Row]) -> Plot | None:
    """Return the share of trials with a bound of p or less against p; None where no trial has a bound."""
    empty = [row for row in rows if row.case.trial in _TRIALS and row.log10_false_positive is not None]
    if not empty:
        return None
    kinds = groups(empty, "scheme", "trial")
    schemes = list(dict.fromkeys(scheme for scheme, _ in kinds))
    entries, samples = [], []
    for (scheme, trial), part in kinds.items():
        words = f"{scheme}, {trial} (n = {len(part)})"
        entries.append(
            Entry(words=words, colour=(2 * schemes.index(scheme) + _TRIALS.index(trial)) % len(COLOURS))
        )
        samples.append(np.array([row.log10_false_positive for row in part], float))
    panel = calibration_panel(entries, samples)
    return Plot(
        title="Are the claimed false-positive rates true?",
        caption=_CAPTION,
        panels=(panel,),
        legend=tuple(entries),
    )


def calibration_panel(entries: Sequence[Entry], samples: Sequence[FloatArray]) -> Panel:
    """Return the picture alone, from the log10 bounds (n,) of each entry's trials, n at least 1."""
    least = -1.0 - np.ceil(np.log10(max(len(sample) for sample in samples)))

    def paint(axes: Axes) -> None:
        axes.plot([least, 0.0], [least, 0.0], color=SOFT, lw=0.8, ls=DASHES[1])
        axes.text(least + 0.1, least + 0.25, "as claimed", color=INK, fontsize=7, rotation=38, va="bottom")
        for entry, sample in zip(entries, samples, strict=True):
            p, share = _steps(sample, least)
            axes.plot(p, share, color=COLOURS[entry.colour], drawstyle="steps-post", lw=1.5)
        _decades(axes, least)
        axes.set_title("false-positive bounds")

    said = "; ".join(
        f"{entry.words}: {percent(share_at_or_below(sample, -1.0))} at or below 0.1"
        for entry, sample in zip(entries, samples, strict=True)
    )
    alt = f"Share of trials with a bound of p or less against p. {said}"
    return draw("calibration", alt, paint, height=2.9, words=["10^-1 sec"])


def share_at_or_below(log10_bounds: FloatArray, at: float) -> float:
    """Return the share of bounds that are 10^at or smaller."""
    return float(np.mean(log10_bounds <= at))


def _steps(sample: FloatArray, least: float) -> tuple[list[float], list[float]]:
    """Return the corners of the share of bounds at or below p, both as log10, from the smallest bound to 1."""
    at = np.sort(np.minimum(sample, 0.0))
    share = np.log10(np.arange(1, len(at) + 1) / len(at))
    return [max(float(at[0]), least), *at, 0.0], [least, *share, 0.0]


def _decades(axes: Axes, least: float) -> None:
    ticks = np.arange(least, 0.5)
    names = ["1" if tick == 0 else f"$10^{{{tick:.0f}}}$" for tick in ticks]
    axes.set_xticks(ticks, names)
    axes.set_yticks(ticks, names)
    axes.set_xlim(least, 0.05)
    axes.set_ylim(least, 0.05)
    axes.set_xlabel("bound claimed by the scheme, p")
    axes.set_ylabel("share of trials at or below p")


_CAPTION = (
    "Models without a mark and marks read with a wrong key. A scheme whose bounds are true stays on the dashed "
    "line or below it; below is cautious, above it finds marks more often than it says."
)

"""What is measured, bar by bar, and the table of it: rows go to a CSV file, so that runs add up."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from meshmark.research.benchmark.figures.intervals import rate
from meshmark.research.training.region_training import area_under_curve

__all__ = ["FIGURES", "SECONDS", "Bar", "Row", "append", "load_rows", "table"]


@dataclass(frozen=True)
class Row:
    """One measurement: a value, or the share of a number of trials with this outcome."""

    figure: str
    model: str
    detail: str
    value: float
    trials: int = 1


@dataclass(frozen=True)
class Bar:
    """measured_by: the name on the command line. kind: what is compared with the target. A rate is that of all
    trials; an area that under the ROC curve of scores, rows of the detail "touched" and "untouched". against: a
    figure that is the target.
    """

    measured_by: str
    kind: str
    target: float
    unit: str = ""
    against: str = ""

    def measured(self, rows: Sequence[Row]) -> float:
        """Return the least, the most, the mean, or the rate of all trials."""
        if self.kind == "area":
            return _area(rows)
        values, trials = (np.array([getattr(row, name) for row in rows]) for name in ("value", "trials"))
        if self.kind in _COMBINED:
            return float(_COMBINED[self.kind](values))
        return float((values * trials).sum() / trials.sum())

    def holds(self, rows: Sequence[Row]) -> bool:
        """Return whether these rows are within the bar."""
        at_most = self.kind in ("most", "rate at most")
        found = self.measured(rows)
        return found <= self.target if at_most else found >= self.target

    @property
    def text(self) -> str:
        """Return what the bar asks for."""
        if self.against:
            return f"at least {self.target:.5f}, the rule's"
        if self.kind == "area":
            return ""
        words = {"least": "each at least", "most": "each at most", "mean": "mean at least"}.get(self.kind)
        if words is None:
            words = "at most" if self.kind == "rate at most" else "at least"
            return f"{words} {100 * self.target:g} %"
        return f"{words} {self.target:g}{self.unit}"


def _area(rows: Sequence[Row]) -> float:
    """Return the area under the ROC curve; 1 where there is only one kind of row."""
    scores = np.array([row.value for row in rows])
    touched = np.array([row.detail == "touched" for row in rows])
    return area_under_curve(scores, touched) if touched.any() and not touched.all() else 1.0


_COMBINED: dict[str, Callable[..., float]] = {"least": np.min, "most": np.max, "mean": np.mean}

SECONDS = "processor seconds"
"""Figure of the rows that tell what a bar, their detail, took on a model; making it marked is one of them."""

# fmt: off
FIGURES = {
    "authentic after a benign operation": Bar("benign", "rate", 1.0),
    "authentic after six significant digits": Bar("benign", "rate", 1.0),
    "PSNR of the layer alone": Bar("benign", "least", 80.0, " dB"),
    "altered after a local edit": Bar("edits", "rate", 1.0),
    "IoU at 0.5 %": Bar("edits", "mean", 0.6),
    "IoU at 2 % and more": Bar("edits", "mean", 0.85),
    "recall at 0.5 %": Bar("edits", "mean", 0.95),
    "recall at 2 % and more": Bar("edits", "mean", 0.95),
    "untouched regions called altered": Bar("edits", "rate at most", 0.01),
    "one point moved by 1 to 2 steps, seen": Bar("moves", "rate", 0.85),
    "ten points so moved, seen": Bar("moves", "rate", 0.999),
    "pasted part flagged": Bar("pastes", "rate", 1.0),
    "share of the pasted part in the map": Bar("pastes", "mean", 0.95),
    "payload at 55 % of the marks, bits per point": Bar("payloads", "least", 1.0),
    "1 bit per point read from a connected 60 % of the surface": Bar("payloads", "rate", 1.0),
    "1 bit per point read from a connected 60 % of the points": Bar("payloads", "rate", 1.0),
    "half of that from 40 % of the marks, scattered": Bar("payloads", "rate", 1.0),
    "half of that from 40 % of all points, scattered": Bar("payloads", "rate", 1.0),
    "RMS after recovery, % of the diagonal": Bar("recovery", "most", 0.7, " %"),
    "times smaller than before": Bar("recovery", "least", 4.0),
    "recovered at all": Bar("recovery", "rate", 1.0),
    "watertight again": Bar("recovery", "rate", 1.0),
    "largest error after unmark, over the diagonal": Bar("unmark", "most", 1e-6),
    "image byte by byte": Bar("payloads", "rate", 1.0),
    "PSNR with both layers": Bar("payloads", "least", 62.0, " dB"),
    "lone marks guessed, accepted": Bar("forgeries", "rate at most", 0.15),
    "forged parts accepted": Bar("forgeries", "rate at most", 0.0),
    "ROC area of the binomial rule": Bar("roc", "area", 0.0),
    "ROC area of the network": Bar("roc", "area", 0.0, against="ROC area of the binomial rule"),
}
# fmt: on


def append(rows: Iterable[Row], path: Path) -> None:
    with path.open("a", newline="") as file:
        csv.writer(file).writerows([*astuple(row)[:3], float(row.value), row.trials] for row in rows)


def load_rows(path: Path) -> list[Row]:
    with path.open(newline="") as file:
        return [Row(a, b, c, float(value), int(trials)) for a, b, c, value, trials in csv.reader(file)]


def table(rows: Sequence[Row]) -> tuple[str, bool]:
    """Return the table of all that was measured, with what missed below it, and whether all bars are met."""
    lines = [
        "| bar | figure | measured | 95 % interval | bar asks | models | met |",
        "|---|---|---|---|---|---|---|",
    ]
    misses, met = [], True
    for name, bar in FIGURES.items():
        own = [row for row in rows if row.figure == name]
        if not own:
            continue
        if bar.against:
            bar = replace(bar, target=bar.measured([row for row in rows if row.figure == bar.against]))
        holds = bar.holds(own)
        met &= holds
        models = len({row.model for row in own})
        cells = [
            bar.measured_by,
            name,
            *_measured(bar, own),
            bar.text,
            str(models),
            "yes" if holds else "**no**",
        ]
        lines.append("| " + " | ".join(cells) + " |")
        if bar.kind == "area":
            continue
        below = Counter(row.detail for row in own if row.detail and not bar.holds([row]))
        if below:
            listed = ", ".join(f"{what} {count}" for what, count in below.most_common())
            misses.append(f"{name}, rows beyond the bar: {listed}")
    return "\n".join([*lines, "", *misses, "", *_seconds(rows)]), met


def _seconds(rows: Sequence[Row]) -> list[str]:
    """Return the lines of a table of what the bars cost."""
    own = [row for row in rows if row.figure == SECONDS]
    if not own:
        return []
    lines = ["| processor seconds | models | median | most | all |", "|---|---|---|---|---|"]
    for bar in dict.fromkeys(row.detail for row in own):
        spent = np.array([row.value for row in own if row.detail == bar])
        cells = (str(len(spent)), f"{np.median(spent):.0f}", f"{spent.max():.0f}", f"{spent.sum():.0f}")
        lines.append(f"| {bar} | {' | '.join(cells)} |")
    total = sum(row.value for row in own)
    return [*lines, f"| all | {len({row.model for row in own})} | | | {total:.0f} |"]


def _measured(bar: Bar, rows: Sequence[Row]) -> tuple[str, str]:
    found, values = bar.measured(rows), [row.value for row in rows]
    if bar.kind == "area":
        touched = sum(row.detail == "touched" for row in rows)
        return f"{found:.5f}", f"{touched} touched, {len(rows) - touched} untouched"
    if bar.kind in _COMBINED:
        spread = f"{min(values):.3g} to {max(values):.3g}, median {np.median(values):.3g}"
        return f"{found:.3g}", f"{spread} ({len(values)})"
    trials = sum(row.trials for row in rows)
    hits = round(found * trials)
    limits = rate(hits, trials)
    assert limits is not None
    return f"{hits} of {trials} ({100 * found:.2f} %)", f"{100 * limits.low:.2f} to {100 * limits.high:.2f} %"

"""How much the marks of a benchmark change the models: each mark counted once, however often it was attacked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.research.benchmark.figures.aggregate import ALL, groups, marked, size_classes
from meshmark.research.benchmark.run.row import Row

__all__ = ["MEASURES", "Distortion", "distortions", "marks"]

# Fields of `Row`: those where less is better, then those where more is.
MEASURES = (
    "rms_over_diagonal",
    "max_over_diagonal",
    "mrms_over_diagonal",
    "hausdorff_over_diagonal",
    "msdm2",
    "normal_deviation_deg",
    "psnr_db",
    "paper_psnr_db",
)


@dataclass(frozen=True)
class Distortion:
    """A measure over the marked models of a scheme, a budget and a size class.

    worst: the largest value, of PSNRs the smallest. count: models that have the figure.
    """

    scheme: str
    budget: str
    size_class: str
    measure: str
    count: int
    mean: float
    median: float
    worst: float


def marks(rows: Sequence[Row]) -> list[Row]:
    """Return one row for each scheme, budget and marked model, with its distortion."""
    having = [row for row in marked(rows) if any(getattr(row, name) is not None for name in MEASURES)]
    first: dict[tuple[str, str, str], Row] = {}
    for row in sorted(having, key=lambda row: row.case):
        first.setdefault((row.case.scheme, row.case.budget, row.case.model), row)
    return list(first.values())


def distortions(rows: Sequence[Row]) -> list[Distortion]:
    """Return one entry for each scheme, budget, size class ("all" first) and measure that has figures."""
    result = []
    for (scheme, budget), part in groups(marks(rows), "scheme", "budget").items():
        for size in (ALL, *size_classes(part)):
            chosen = [row for row in part if size in (ALL, row.size_class)]
            for measure in MEASURES:
                values = [value for row in chosen if (value := getattr(row, measure)) is not None]
                finite = [value for value in values if np.isfinite(value)]
                if finite:
                    worst = min(finite) if measure.endswith("_db") else max(finite)
                    centre = float(np.mean(finite)), float(np.median(finite))
                    result.append(Distortion(scheme, budget, size, measure, len(finite), *centre, worst))
    return result

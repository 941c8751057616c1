"""How long embedding and extraction take, how that grows with the model, and how much memory they need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.research.benchmark.figures.aggregate import ALL, groups, marked, size_classes
from meshmark.research.benchmark.run.row import Row

__all__ = ["Speed", "Timing", "growth", "speeds", "timings"]

# Growth is told from at least three models of which the largest has at least twice the points of the smallest.
_FEWEST, _SPREAD = 3, 2.0


@dataclass(frozen=True, kw_only=True)
class Timing:
    """One model of a scheme and budget: median seconds, None where nothing was measured."""

    scheme: str
    budget: str
    model: str
    size_class: str
    points: int
    embed: float | None
    extract: float | None
    file: float | None
    vertices_per_second: float | None
    peak_mb: float | None


@dataclass(frozen=True, kw_only=True)
class Speed:
    """Medians over the models of a size class, and the largest memory.

    embed_growth, extract_growth: the exponent g of seconds ~ points^g, 1 for twice the time at twice the points.
    """

    scheme: str
    budget: str
    size_class: str
    models: int
    points: float
    embed: float | None
    extract: float | None
    file: float | None
    vertices_per_second: float | None
    peak_mb: float | None
    embed_growth: float | None
    extract_growth: float | None


def timings(rows: Sequence[Row]) -> list[Timing]:
    """Return the times of each scheme, budget and model; a mark made once is one time of embedding."""
    result = []
    read = [row for row in marked(rows) if row.status == "ok" and row.points]
    for (scheme, budget, model), part in groups(read, "scheme", "budget", "model").items():
        made = sorted({row.embed_seconds for row in part if row.embed_seconds is not None})
        peaks = [row.peak_mb for row in part if row.peak_mb is not None]
        result.append(
            Timing(
                scheme=scheme,
                budget=budget,
                model=model,
                size_class=part[0].size_class or "",
                points=part[0].points or 0,
                embed=_median(made),
                extract=_median([row.extract_seconds for row in part]),
                file=_median([row.file_seconds for row in part]),
                vertices_per_second=_median([row.vertices_per_second for row in part]),
                peak_mb=max(peaks, default=None),
            )
        )
    return result


def speeds(rows: Sequence[Row]) -> list[Speed]:
    """Return one entry for each scheme, budget and size class, "all" first."""
    result = []
    for (scheme, budget), part in groups(marked(rows), "scheme", "budget").items():
        timed = timings(part)
        for size in (ALL, *size_classes(part)):
            chosen = [timing for timing in timed if size in (ALL, timing.size_class)]
            if chosen:
                result.append(_speed(scheme, budget, size, chosen))
    return result


def growth(points: Sequence[float], seconds: Sequence[float | None]) -> float | None:
    """Return the slope of log seconds over log points by least squares; None for too few or too equal sizes."""
    pairs = [(p, s) for p, s in zip(points, seconds, strict=True) if s is not None and s > 0.0 and p > 0]
    if len(pairs) < _FEWEST or max(pairs)[0] < _SPREAD * min(pairs)[0]:
        return None
    x, y = np.log(np.asarray(pairs, float)).T
    x = x - x.mean()
    return float(x @ y / (x @ x))


def _speed(scheme: str, budget: str, size: str, chosen: list[Timing]) -> Speed:
    points = [timing.points for timing in chosen]
    peaks = [timing.peak_mb for timing in chosen if timing.peak_mb is not None]
    return Speed(
        scheme=scheme,
        budget=budget,
        size_class=size,
        models=len(chosen),
        points=float(np.median(points)),
        embed=_median([timing.embed for timing in chosen]),
        extract=_median([timing.extract for timing in chosen]),
        file=_median([timing.file for timing in chosen]),
        vertices_per_second=_median([timing.vertices_per_second for timing in chosen]),
        peak_mb=max(peaks, default=None),
        embed_growth=growth(points, [timing.embed for timing in chosen]),
        extract_growth=growth(points, [timing.extract for timing in chosen]),
    )


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None

"""What was measured, laid out as the paper's tables ask for it: by scheme, attack, model, and groups of models."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.research.benchmark.figures.aggregate import main_split, size_classes
from meshmark.research.benchmark.figures.intervals import Estimate, mean
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, percent
from meshmark.research.benchmark.paper.published_claims import CLAIMED, CLASSES
from meshmark.research.benchmark.run.row import Row

__all__ = ["OWN", "Group", "Measured", "Values", "db_cell", "db_estimate", "share_cell", "title_of"]

OWN = "ncdg_lv"
Values = Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Group:
    """Some models: of a class of the paper (its number from 0), of a size, or all (class None)."""

    label: str
    models: frozenset[str]
    claim: int | None = None
    average: bool = False


class Measured:
    """The rows of a run of the paper's suite, of the split that results are quoted for."""

    def __init__(self, rows: Sequence[Row], classes: Mapping[str, str]) -> None:
        """Lay out the rows; classes: of the models that have one."""
        split = main_split(rows)
        self.rows = [row for row in rows if split in ("all", row.split)]
        self.classes = classes
        found = {row.case.scheme for row in self.rows}
        order = [OWN, *CLAIMED, *sorted(found)]
        self.schemes = [name for name in dict.fromkeys(order) if name in found]
        self._at: dict[tuple[str, str], dict[str, Row]] = {}
        for row in self.rows:
            if row.case.trial == "marked" and row.case.repeat == 0:
                self._at.setdefault((row.case.scheme, row.case.attack), {})[row.case.model] = row

    def of(self, scheme: str, attack: str) -> dict[str, Row]:
        """Return the row of each model of a scheme under an attack."""
        return self._at.get((scheme, attack), {})

    def values(self, scheme: str, attacks: Iterable[str], figure: Callable[[Row], float | None]) -> Values:
        """Return for each model the mean of a figure over attacks, where it was marked and read under them."""
        found: dict[str, list[float]] = {}
        for attack in attacks:
            for model, row in self.of(scheme, attack).items():
                value = figure(row) if row.status == "ok" else None
                if value is not None and np.isfinite(value):
                    found.setdefault(model, []).append(float(value))
        return {model: float(np.mean(values)) for model, values in found.items()}

    def groups(self) -> list[Group]:
        """Return the paper's ten classes, all models, and the size classes; those without a model are left out."""
        models = {row.case.model for row in self.rows}
        size = {row.case.model: row.size_class for row in self.rows}
        by_class = [
            Group(
                label=f"Model{i} ({name})",
                models=frozenset(m for m in models if self.classes.get(m) == name),
                claim=i - 1,
            )
            for i, name in enumerate(CLASSES, 1)
        ]
        everything = Group(label="all models", models=frozenset(models), average=True)
        by_size = [
            Group(label=f"{name} points", models=frozenset(m for m in models if size[m] == name))
            for name in size_classes(self.rows)
        ]
        return [*by_class, everything, *(group for group in by_size if group.models)]


def title_of(scheme: str) -> str:
    """Return the paper's name of a scheme, or its own."""
    return CLAIMED.get(scheme, scheme)


def share_cell(values: Sequence[float]) -> Cell:
    """Return the mean of shares with its interval and the number of models."""
    found = mean(values)
    if found is None:
        return Cell(text=NOTHING)
    interval = f"{percent(found.low, 0)[:-2]}–{percent(found.high, 0)}, n {found.count}"
    return Cell(text=percent(found.value, 2), small=interval, heat=max(0.0, 1.0 - 2.0 * found.value))


def db_cell(values: Sequence[float]) -> Cell:
    """Return the mean of decibels with its interval and the number of models."""
    found = db_estimate(values)
    if found is None:
        return Cell(text=NOTHING)
    interval = f"{found.low:.1f}–{found.high:.1f}, " if found.count > 1 else ""
    return Cell(text=f"{found.value:.2f}", small=f"{interval}n {found.count}")


def db_estimate(values: Sequence[float]) -> Estimate | None:
    """Return the mean of values without known limits, with Student's 95 % interval; None for no values."""
    from scipy.stats import t

    if not values:
        return None
    centre, count = float(np.mean(values)), len(values)
    if count == 1:
        return Estimate(centre, -np.inf, np.inf, 1)
    half = float(t.ppf(0.975, count - 1) * np.std(values, ddof=1) / np.sqrt(count))
    return Estimate(centre, centre - half, centre + half, count)

"""The ablation of saliency and segmentation: what the map of regions is worth with other modules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from meshmark.research.ablation.modules import FULL
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Table, number, percent
from meshmark.research.benchmark.paper.measured import db_estimate, share_cell
from meshmark.research.training.region_training import area_under_curve

__all__ = ["Figures", "area", "in_words", "map_table", "verdict_table"]

Figures = Mapping[str, Mapping[str, Any]]

_WORDS = {"nc_dgg": "NC-DGG", "random": "random vertices", "laplace_beltrami": "Laplace–Beltrami", "map": "map",
          "k_means": "k-means", "fuzzy_c_means": "fuzzy c-means"}  # fmt: skip
# What is compared with the full system, and the sign that makes more the better.
_MEASURES = {"balance": -1.0, "same region": 1.0, "called": -1.0}


def map_table(regions: Sequence[Figures]) -> Table:
    """Return what the maps are like, and how each stands against that of the full system."""
    rows = []
    for choice in regions[0]:
        own = _measures(regions, choice)
        balance = own["balance"].values()
        seconds = [figures[choice]["seconds"] for figures in regions if choice in figures]
        rows.append(
            (
                Cell(text=in_words(choice)),
                Cell(text=number(float(np.median([*balance]))), small=f"worst {number(max(balance))}"),
                *(_neutral([*own[name].values()]) for name in ("same region", "called")),
                Cell(text=f"{number(1000 * float(np.median(seconds)))} ms"),
                Cell(text=_against(own, _measures(regions, FULL.map)) if choice != FULL.map else NOTHING),
            )
        )
    columns = (
        *("saliency + segmentation", "balance", "same region on a copy", "called, of the surface", "time"),
        "against the full system",
    )
    note = (
        f"Models: {len(regions)}. Balance: largest over mean share of a region in its half, 1 is what eq. 7 "
        "asks for, median. Same region on a copy: share of points that the map puts into the same region "
        "after 0.3 % noise, a turn and a shuffle of the vertices; more is better. Called: area of the "
        "regions called altered after local edits; less names the place better. Better and worse: by more "
        "than chance over the models (95 %). The per-point map, recovery and id depend on none of these "
        "modules."
    )
    return Table(title="Ablation: saliency and segmentation", columns=columns, rows=tuple(rows), note=note)


def _measures(regions: Sequence[Figures], choice: str) -> dict[str, dict[int, float]]:
    """Return each of `_MEASURES` by the number of the model."""
    found: dict[str, dict[int, float]] = {name: {} for name in _MEASURES}
    for i, figures in enumerate(regions):
        own = figures.get(choice)
        if own is None:
            continue
        found["balance"][i] = own["balance"]
        if own["agreement"] is not None:
            found["same region"][i] = own["agreement"]
        if own["called"]:
            found["called"][i] = float(np.mean(own["called"]))
    return found


def _against(own: Mapping[str, Mapping[int, float]], whole: Mapping[str, Mapping[int, float]]) -> str:
    said: dict[str, list[str]] = {"better": [], "worse": [], "no clear difference": []}
    for name, sign in _MEASURES.items():
        both = sorted(own[name].keys() & whole[name].keys())
        lead = db_estimate([sign * (own[name][i] - whole[name][i]) for i in both])
        if lead is None:
            continue
        clear = "better" if lead.low > 0.0 else "worse" if lead.high < 0.0 else "no clear difference"
        said[clear].append(name)
    return "; ".join(f"{words}: {', '.join(names)}" for words, names in said.items() if names)


def verdict_table(regions: Sequence[Figures]) -> Table:
    """Return how well the network and the binomial rule tell altered regions from intact ones."""
    rows = []
    for choice in regions[0]:
        for rule, words in (("network", "LM network"), ("rule", "binomial rule")):
            scores, truth = _pooled(regions, choice, rule)
            called = scores > 0.0
            rows.append(
                (
                    Cell(text=in_words(choice)),
                    Cell(text=words),
                    Cell(text=str(len(truth)), small=f"{int(truth.sum())} altered"),
                    Cell(text=area(regions, choice, rule)),
                    Cell(text=percent(_mean(~called[truth]), 2)),
                    Cell(text=percent(_mean(called[~truth]), 2)),
                )
            )
    columns = (
        "saliency + segmentation",
        "extraction",
        "regions",
        "area under ROC",
        "altered, missed",
        "intact, called",
    )
    note = (
        "Regions of models marked for authentication, untouched and after local edits: bump, dent, moved, "
        "deleted or replaced part."
    )
    return Table(
        title="Ablation: extraction, verdicts on regions", columns=columns, rows=tuple(rows), note=note
    )


def _pooled(regions: Sequence[Figures], choice: str, rule: str) -> tuple[Any, Any]:
    own = [figures[choice] for figures in regions if choice in figures]
    scores = np.concatenate([np.asarray(f[rule], float) for f in own])
    truth = np.concatenate([np.asarray(f["altered"], float) > 0.5 for f in own])
    return scores, truth


def area(regions: Sequence[Figures], choice: str, rule: str) -> str:
    """Return the area under the ROC curve of the network or the rule, over the regions of all models."""
    if not any(choice in figures for figures in regions):
        return NOTHING
    scores, truth = _pooled(regions, choice, rule)
    return f"{area_under_curve(scores, truth):.4f}" if truth.any() and not truth.all() else NOTHING


def in_words(choice: str) -> str:
    """Return a choice of modules in words."""
    return " + ".join(_WORDS.get(part, part) for part in choice.split(" + "))


def _neutral(values: Sequence[float]) -> Cell:
    cell = share_cell(values)
    return Cell(text=cell.text, small=cell.small)


def _mean(flags: Any) -> float | None:
    return float(np.mean(flags)) if len(flags) else None

"""What saliency and segmentation are worth: maps of regions on marked, edited and re-exported models."""

from __future__ import annotations

from time import perf_counter
from typing import Any, Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from meshmark.attacks.chain import parse_chain
from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.weld import weld
from meshmark.mesh import IntArray, Mesh
from meshmark.research.ablation.extraction_rules import EXTRACTIONS
from meshmark.research.ablation.modules import FULL, Modules, region_map
from meshmark.research.training.region_trials import Edited, edited_models, judged
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["CHOICES", "agreement", "region_figures"]

# The full system, each single swap, and the two swaps of the paper's ablation table.
CHOICES: Final = (
    FULL,
    Modules(saliency="random"),
    Modules(saliency="laplace_beltrami"),
    Modules(segmentation="k_means"),
    Modules(segmentation="fuzzy_c_means"),
    Modules(saliency="random", segmentation="k_means"),
)
EDITS: Final = 4
# A copy that went through other hands: slightly noisy, turned, its vertices in another order.
COPY: Final = "noise:0.003+similarity:1+shuffle:1"


def region_figures(mesh: Mesh, rng: np.random.Generator) -> dict[str, Any]:
    """Return the figures of each of `CHOICES` under "saliency + segmentation".

    balance: of the map, 1 is perfect; agreement: share of points in the same region again on a copy; seconds: for
    the map. Of the regions of all edited models, as lists: altered (in truth, 0 or 1); network, rule: what they say
    (above 0: altered); called: share of the surface in regions called altered, per edited model.
    Raises what marking raises.
    """
    seed = int(rng.integers(1 << 62))
    models = list(edited_models(mesh, rng, EDITS))
    copy = parse_chain(COPY).apply(models[0].mesh, rng)
    figures = {}
    for modules in CHOICES:
        start = perf_counter()
        maps = [region_map(edited.found.surface, modules, np.random.default_rng(seed)) for edited in models]
        seconds = (perf_counter() - start) / len(models)
        other = region_map(weld(copy.mesh), modules, np.random.default_rng(seed))
        figures[modules.map] = {
            "balance": maps[0].balance,
            "agreement": _on_copy(models[0].mesh, maps[0], copy.mesh, other, copy.origin),
            "seconds": seconds,
            **_verdicts(models, maps),
        }
    return figures


def agreement(one: IntArray, other: IntArray) -> float:
    """Return the share of points (p,) in the same region of two maps, their regions matched as well as can be."""
    count = int(max(one.max(initial=0), other.max(initial=0))) + 1
    table = np.bincount(one * count + other, minlength=count * count).reshape(count, count)
    return float(table[linear_sum_assignment(-table)].sum() / max(len(one), 1))


def _on_copy(mesh: Mesh, map_: Regions, copy: Mesh, other: Regions, origin: IntArray | None) -> float | None:
    if origin is None:
        return None
    before = map_.region[weld(mesh).point_of_vertex]
    after = other.region[weld(copy).point_of_vertex]
    kept = origin >= 0
    return agreement(before[origin[kept]], after[kept])


def _verdicts(models: list[Edited], maps: list[Regions]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {"altered": [], "called": [], **{name: [] for name in EXTRACTIONS}}
    for edited, map_ in zip(models, maps, strict=True):
        trial = judged(edited, map_)
        found["altered"] += trial.altered.any(axis=1).astype(float).tolist()
        for name, extraction in EXTRACTIONS.items():
            found[name] += np.round(extraction.regions(trial), 3).tolist()
        if edited.edit:
            called = np.flatnonzero(EXTRACTIONS[FULL.extraction].regions(trial) > 0.0)
            areas = vertex_areas(edited.found.surface.points, edited.found.surface.faces)
            found["called"].append(float(areas[np.isin(map_.region, called)].sum() / areas.sum()))
    return found

"""Regions of locally edited models of which it is known what was altered: what the classifier learns from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks import find_attack
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.schemes.ncdg_lv.authentication.examination import examine
from meshmark.schemes.ncdg_lv.authentication.region_evidence import region_evidence
from meshmark.schemes.ncdg_lv.layers import embed
from meshmark.segmentation.analysis import segment
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["EDITS", "SHARES", "RegionTrial", "region_trials"]

EDITS: Final = ("bump", "dent", "move_part", "delete_part", "replace_part")
SHARES: Final = (0.005, 0.02, 0.05, 0.2)
"""Of the points of the model."""


@dataclass(frozen=True, eq=False)
class RegionTrial:
    """One edited model of n regions.

    features: (n, 2, d) and log10_chance (n, 2) of its evidence; home: (n,); altered: (n, 2) whether a point of that
    half was altered in truth.
    """

    edit: str
    share: float
    features: FloatArray
    log10_chance: FloatArray
    home: NDArray[np.bool_]
    altered: NDArray[np.bool_]


def region_trials(mesh: Mesh, rng: np.random.Generator, edits: int) -> Iterator[RegionTrial]:
    """Mark a model and yield it as it is and after `edits` different local edits.

    Raises what `embed` raises; an edit that the model does not take is passed over.
    """
    key = Key(rng.bytes(32))
    marked = embed(mesh, key, id=int(rng.integers(1 << 62)), layers="authentication", payload="none").mesh
    yield _trial("", 0.0, marked, np.zeros(len(marked.vertices), bool), key)
    ways = [(edit, share) for edit in EDITS for share in SHARES]
    for number in rng.permutation(len(ways))[:edits]:
        edit, share = ways[number]
        try:
            made = find_attack(edit).apply(marked, share, rng)
        except MeshmarkError:
            continue
        truth = np.zeros(len(made.mesh.vertices), bool) if made.altered is None else made.altered
        yield _trial(edit, share, made.mesh, truth, key)


def _trial(edit: str, share: float, mesh: Mesh, truth: NDArray[np.bool_], key: Key) -> RegionTrial:
    surface = weld(mesh)
    found = examine(mesh, key)
    map_ = segment(mesh)
    first = surface.vertex_of_point
    regions = Regions(map_.region[first], map_.green[first], map_.green_share, map_.blue_share)
    evidence = region_evidence(surface.faces, regions, found.checks, found.altered)
    used = np.zeros(len(surface.points), bool)
    used[surface.faces] = True
    cell = 2 * regions.region + ~regions.green
    altered = np.bincount(cell[truth[first] & used], minlength=2 * len(evidence.home)).reshape(-1, 2) > 0
    return RegionTrial(edit, share, evidence.features, evidence.log10_chance, evidence.home, altered)

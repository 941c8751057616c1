"""Regions of locally edited models of which it is known what was altered: what the classifier learns from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks import find_attack
from meshmark.authentication.examination import Examination, examine
from meshmark.authentication.regions.region_evidence import region_evidence
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.marking.both_layers import embed
from meshmark.mesh import FloatArray, Mesh
from meshmark.segmentation.analysis import segment
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["EDITS", "SHARES", "Edited", "RegionTrial", "edited_models", "judged", "region_trials"]

EDITS: Final = ("bump", "dent", "move_part", "delete_part", "replace_part")
SHARES: Final = (0.005, 0.02, 0.05, 0.2)
"""Of the points of the model."""


@dataclass(frozen=True, eq=False, kw_only=True)
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Edited:
    """A marked and then edited model: what its marks say, and which of its points (p,) were altered in truth."""

    edit: str
    share: float
    mesh: Mesh
    found: Examination
    truth: NDArray[np.bool_]


def region_trials(mesh: Mesh, rng: np.random.Generator, edits: int) -> Iterator[RegionTrial]:
    """Mark a model and yield it as it is and after `edits` different local edits.

    Raises what `embed` raises; an edit that the model does not take is passed over.
    """
    for edited in edited_models(mesh, rng, edits):
        map_ = segment(edited.mesh)
        first = edited.found.surface.vertex_of_point
        regions = Regions(
            region=map_.region[first],
            green=map_.green[first],
            green_share=map_.green_share,
            blue_share=map_.blue_share,
        )
        yield judged(edited, regions)


def edited_models(mesh: Mesh, rng: np.random.Generator, edits: int) -> Iterator[Edited]:
    """Mark a model and yield it as it is and after `edits` different local edits; see `region_trials`."""
    key = Key(rng.bytes(32))
    marked = embed(mesh, key, id=int(rng.integers(1 << 62)), layers="authentication", payload="none").mesh
    yield _edited("", 0.0, marked, np.zeros(len(marked.vertices), bool), key)
    ways = [(edit, share) for edit in EDITS for share in SHARES]
    for number in rng.permutation(len(ways))[:edits]:
        edit, share = ways[number]
        try:
            made = find_attack(edit).apply(marked, share, rng)
        except MeshmarkError:
            continue
        truth = np.zeros(len(made.mesh.vertices), bool) if made.altered is None else made.altered
        yield _edited(edit, share, made.mesh, truth, key)


def _edited(edit: str, share: float, mesh: Mesh, truth: NDArray[np.bool_], key: Key) -> Edited:
    found = examine(mesh, key)
    used = np.zeros(len(found.surface.points), bool)
    used[found.surface.faces] = True
    return Edited(
        edit=edit, share=share, mesh=mesh, found=found, truth=truth[found.surface.vertex_of_point] & used
    )


def judged(edited: Edited, regions: Regions) -> RegionTrial:
    """Return what the marks of an edited model say of the regions of a map of its points."""
    found = edited.found
    evidence = region_evidence(found.surface.graph, regions, found.checks, found.altered)
    cell = 2 * regions.region + ~regions.green
    altered = np.bincount(cell[edited.truth], minlength=2 * len(evidence.home)).reshape(-1, 2) > 0
    return RegionTrial(
        edit=edited.edit,
        share=edited.share,
        features=evidence.features,
        log10_chance=evidence.log10_chance,
        home=evidence.home,
        altered=altered,
    )

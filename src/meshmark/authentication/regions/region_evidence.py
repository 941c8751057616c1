"""What the checks of a region say in the paper's two passes, top half and bottom half: counts and features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.authentication.checks.checks import Checks
from meshmark.geometry.components import connected_parts
from meshmark.mesh import FloatArray, IntArray
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["FEATURES", "RegionEvidence", "region_evidence"]

FEATURES = (
    "failed checks, -log10 chance",
    "failed checks, share",
    "failed checks, log count",
    "points without a mark, share",
    "points without a mark or a neighbour with one, share",
    "largest share of an altered part",
    "largest altered part, log points",
    "marks, over the usual",
    "checks, log count",
    "failed checks in the other half, share",
)
"""Inputs of the classifier, for each half of each region."""

# Share of the checks of an intact region that may fail because of altered neighbours across its border.
_SPILL = 0.02
# Checks of neighbours share marks: this number of them fails together.
_TOGETHER = 4.0
_LARGEST = 30.0


@dataclass(frozen=True, eq=False, kw_only=True)
class RegionEvidence:
    """Of n regions; the rows of two columns are the top (green) and the bottom (blue) half.

    checks, failed: (n, 2) points that could be checked, and those of them that are altered. log10_chance: (n, 2) of
    at least as many failed checks in an intact half. home: (n,) whether an altered part lies mostly in the region.
    features: (n, 2, 10), see `FEATURES`.
    """

    checks: IntArray
    failed: IntArray
    log10_chance: FloatArray
    home: NDArray[np.bool_]
    features: FloatArray


def region_evidence(
    graph: csr_array, regions: Regions, checks: Checks, altered: NDArray[np.bool_]
) -> RegionEvidence:
    """Return what the checks say of each region.

    Parameters
    ----------
    graph : (p, p) sparse matrix
        The vertex graph of the suspect's surface (`Surface.graph`).
    regions : Regions
        Region and half of each point.
    checks : Checks
        Which marks hold.
    altered : (p,) bool array
        The points that the map shows as altered.

    Returns
    -------
    RegionEvidence
    """
    count = len(regions.green_share)
    cell = 2 * regions.region + ~regions.green  # a half of a region

    def tally(points: NDArray[np.bool_]) -> FloatArray:
        return np.bincount(cell[points], minlength=2 * count).astype(float)

    checked = checks.eligible | checks.verified
    bare = checks.eligible & ~checks.verified
    deep = bare & ~(np.asarray(graph @ checks.verified.astype(float)) > 0.0)
    total, failed = tally(checked), tally(checked & altered)
    chance = _log10_tail(np.ceil(failed / _TOGETHER), np.ceil(total / _TOGETHER))
    held, size = _parts_by_cell(graph, altered, cell, 2 * count)
    share = failed / np.maximum(total, 1.0)
    marks = tally(checks.passed) / np.maximum(total, 1.0)
    usual = float(np.median(marks[total > 0.0])) if (total > 0.0).any() else 1.0
    largest = (held / np.maximum(size[:, None], 1.0)).max(axis=0, initial=0.0)
    columns = [
        np.minimum(-chance, _LARGEST),
        share,
        np.log1p(failed),
        tally(bare) / np.maximum(total, 1.0),
        tally(deep) / np.maximum(total, 1.0),
        largest,
        np.log1p((size[:, None] * (held > 0.0)).max(axis=0, initial=0.0)),
        np.minimum(marks / max(usual, 1e-9), 3.0),
        np.log1p(total),
        share.reshape(-1, 2)[:, ::-1].ravel(),
    ]
    home = np.zeros(count, bool)
    if len(held):
        home[held.reshape(len(held), count, 2).sum(axis=2).argmax(axis=1)] = True
    return RegionEvidence(
        checks=total.reshape(-1, 2).astype(np.int64),
        failed=failed.reshape(-1, 2).astype(np.int64),
        log10_chance=chance.reshape(-1, 2),
        home=home,
        features=np.stack(columns, axis=1).reshape(count, 2, len(FEATURES)),
    )


def _log10_tail(failed: FloatArray, checks: FloatArray) -> FloatArray:
    """Return log10 of the chance (k,) of at least `failed` failures in `checks` checks of an intact region."""
    from scipy.special import betainc

    least, rest = np.maximum(failed, 1.0), np.maximum(checks - failed, 0.0) + 1.0
    tail = np.where(failed > 0.0, betainc(least, rest, _SPILL), 1.0)
    return np.asarray(np.log10(np.maximum(tail, 1e-300)))


def _parts_by_cell(
    graph: csr_array, altered: NDArray[np.bool_], cell: IntArray, cells: int
) -> tuple[FloatArray, FloatArray]:
    """Return (parts, cells): the points of each connected altered part in each cell, and (parts,) in all."""
    rows = np.flatnonzero(altered)
    part = connected_parts(graph, altered)[rows]
    held = np.zeros((int(part.max(initial=-1)) + 1, cells))
    np.add.at(held, (part, cell[rows]), 1.0)
    return held, held.sum(axis=1)

"""The verdict per region: a binomial test of failed checks in the paper's two passes, top half and bottom half."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.special import bdtrc

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import FloatArray, IntArray
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["Region", "connected_parts", "judge_regions"]

# Of the checks of an intact region so many may fail, for the sake of altered neighbours across its border.
_SPILL = 0.02
# Checks of neighbours share marks: so many fail together.
_TOGETHER = 4.0
# An intact region is called altered this seldom.
_ERROR = 1e-3


@dataclass(frozen=True)
class Region:
    """One region of the map.

    id: its number in the map; verdict: "intact", "altered" or "unchecked" (no ring large enough for a mark);
    probability: 1 less the chance of at least so many failed checks in an intact region, of the worse half.
    checks: points whose ring could carry a mark; failed: those that are altered. centre: (x, y, z).
    """

    id: int
    verdict: str
    probability: float
    checks: int
    failed: int
    centre: tuple[float, float, float]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {**self.__dict__, "centre": list(self.centre)}


def judge_regions(
    points: FloatArray,
    faces: IntArray,
    areas: FloatArray,
    regions: Regions,
    checked: NDArray[np.bool_],
    altered: NDArray[np.bool_],
) -> tuple[Region, ...]:
    """Return the verdict of each region.

    points (p, 3), faces (m, 3), areas (p,) of the points; checked (p,): points that could be told; altered (p,).
    """
    count = len(regions.green_share)
    at = regions.region
    total = np.bincount(at[checked], minlength=count)
    failed = np.bincount(at[checked & altered], minlength=count)
    chance = np.ones(count)
    for half in (regions.green, ~regions.green):
        n = np.bincount(at[checked & half], minlength=count) / _TOGETHER
        f = np.bincount(at[checked & altered & half], minlength=count) / _TOGETHER
        chance = np.minimum(chance, 2.0 * _tail(np.ceil(f), np.ceil(n)))
    called = chance < _ERROR
    called[_homes(faces, at, altered)] = True
    weight = np.bincount(at, areas, count)
    moments = np.stack([np.bincount(at, areas * points[:, axis], count) for axis in range(3)], axis=1)
    centres = moments / np.where(weight > 0.0, weight, 1.0)[:, None]
    return tuple(
        Region(
            i,
            "altered" if called[i] else "intact" if total[i] else "unchecked",
            float(1.0 - min(chance[i], 1.0)),
            int(total[i]),
            int(failed[i]),
            (float(centres[i, 0]), float(centres[i, 1]), float(centres[i, 2])),
        )
        for i in range(count)
    )


def _tail(failed: FloatArray, checks: FloatArray) -> FloatArray:
    """Return the chance (k,) of at least so many failures in so many checks of an intact region."""
    return np.asarray(np.where(failed > 0.0, bdtrc(np.maximum(failed, 1.0) - 1.0, checks, _SPILL), 1.0))


def _homes(faces: IntArray, region: IntArray, altered: NDArray[np.bool_]) -> IntArray:
    """Return the region that holds most of each connected altered part: a small part must not be overlooked."""
    rows = np.flatnonzero(altered)
    if not len(rows):
        return rows
    part = connected_parts(faces, altered)[rows]
    held = np.zeros((int(part.max()) + 1, int(region.max()) + 1), np.int64)
    np.add.at(held, (part, region[rows]), 1)
    return np.unique(held.argmax(axis=1))


def connected_parts(faces: IntArray, altered: NDArray[np.bool_]) -> IntArray:
    """Return (p,): which connected altered part each point belongs to, -1 for points that are not altered."""
    rows = np.flatnonzero(altered)
    part = np.full(len(altered), -1)
    if len(rows):
        graph = adjacency(unique_edges(faces), len(altered))[rows][:, rows]
        part[rows] = connected_components(graph, directed=False)[1]
    return part

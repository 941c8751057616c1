"""Mean and variance of vertex norms in bins (Cho, Prost, Jung 2007, doi:10.1109/TSP.2006.882111)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.histogram import MEAN, VARIANCE, Statistic, bins_of, raised, within
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.rivals.tuning import strongest
from meshmark.research.schemes.scheme import Bits

__all__ = ["ChoMean", "ChoVariance", "norm_margins", "shifted_norms"]

# Moving the points moves their mean: so often it is sought again, until it stays, in largest norms.
PASSES, CONVERGED = 8, 1e-10
# Margins beyond the middle: the largest that the mapped norms allow, and one that can just be read.
LARGEST, SMALLEST = {MEAN: 0.45, VARIANCE: 0.3}, 1e-4


@dataclass(frozen=True)
class ChoMean(Rival):
    """One bit for each bin of the vertex norms, by their mean; one more bin for each pilot."""

    title = "Cho mean"
    source = "Cho, Prost, Jung 2007, doi:10.1109/TSP.2006.882111"
    reconstruction = "keyed scrambling and pilots are ours; the strength is tuned to the budget"
    pilots: int = 16
    statistic = MEAN

    def _placed(self, host: Host, code: Bits, _key: Key, budget: float) -> FloatArray:
        def place(margin: float) -> FloatArray:
            return shifted_norms(host.points, code, self.statistic, margin)

        return strongest(place, host.rms, budget, SMALLEST, LARGEST[self.statistic])[1]

    def _seen(self, host: Host, _key: Key, _reference: Any) -> tuple[FloatArray, int]:
        return -norm_margins(host.points, self._length, self.statistic), 1


@dataclass(frozen=True)
class ChoVariance(ChoMean):
    """The same with the variance of the norms."""

    title = "Cho variance"
    statistic = VARIANCE


def norm_margins(points: FloatArray, count: int, statistic: Statistic, trim: float = 0.0) -> FloatArray:
    """Return (count,): what the bins of the points' (n, 3) distances from their mean say, positive for 1.

    trim: the share of points left out at either end, 0 as published.
    """
    norms = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return bins_of(norms[within(norms, trim)], count).margins(statistic)


def shifted_norms(
    points: FloatArray, code: Bits, statistic: Statistic, margin: float, trim: float = 0.0
) -> FloatArray:
    """Return the points (n, 3) moved towards or away from a centre so that their bins carry the code (c,).

    The centre is the one that is the mean of the points *after* they were moved, where the reader looks for it.
    """
    centre = points.mean(axis=0)
    placed = points
    for _ in range(PASSES):
        arms = points - centre
        norms = np.linalg.norm(arms, axis=1)
        inside = within(norms, trim)
        new = norms.copy()
        new[inside] = raised(bins_of(norms[inside], len(code)), code, statistic, margin)
        placed = centre + arms * (new / np.where(norms > 0.0, norms, 1.0))[:, None]
        step, centre = placed.mean(axis=0) - centre, placed.mean(axis=0)
        if np.abs(step).max() <= CONVERGED * norms.max():
            break
    return placed

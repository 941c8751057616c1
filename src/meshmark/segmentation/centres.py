"""Centres of regions: k-means from the salient points on, by area (Lloyd 1982, doi:10.1109/TIT.1982.1056489)."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.segmentation.power_diagram import assign, condensed

__all__ = ["PASSES", "STILL", "settled_centres"]

PASSES, LAST_PASSES = 60, 8
"""At most; centres that move less than `STILL` times the extent end the passes before."""
STILL = 1e-5


def settled_centres(points: FloatArray, areas: FloatArray, centres: FloatArray) -> FloatArray:
    """Return the centres (n, 3) that k-means of points (p, 3) with areas (p,) ends with, started from `centres`.

    Of many points those in each cube of a fine grid count as one at first, then each for itself for a few passes.
    """
    still = STILL * float(np.ptp(points, axis=0).max())
    groups, masses = condensed(points, areas)
    centres = _settled(groups, masses, centres, still, PASSES)
    return centres if groups is points else _settled(points, areas, centres, still, LAST_PASSES)


def _settled(
    points: FloatArray, areas: FloatArray, centres: FloatArray, still: float, passes: int
) -> FloatArray:
    none = np.zeros(len(centres))
    for _ in range(passes):
        region = assign(points, centres, none)
        mass = np.bincount(region, areas, len(centres))
        sums = np.stack([np.bincount(region, areas * axis, len(centres)) for axis in points.T], axis=1)
        moved = np.where(mass[:, None] > 0.0, sums / np.where(mass, mass, 1.0)[:, None], centres)
        step, centres = float(np.abs(moved - centres).max()), moved
        if step <= still:
            break
    return centres

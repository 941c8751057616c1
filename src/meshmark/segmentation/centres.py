"""Centres of regions: k-means from the salient points on, by area (Lloyd 1982, doi:10.1109/TIT.1982.1056489)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.segmentation.power_diagram import assign, condensed

__all__ = ["converged_centres", "lloyd_iterations"]

PASSES, LAST_PASSES = 60, 8
"""At most; centres that move less than `STILL` times the extent end the passes before."""
STILL = 1e-5

Held = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Takes centres (n, 3); returns the sums of places (n, 3) and the masses (n,) that they hold."""


def converged_centres(points: FloatArray, areas: FloatArray, centres: FloatArray) -> FloatArray:
    """Return the centres (n, 3) that k-means of points (p, 3) with areas (p,) ends with, started from `centres`.

    Of many points those in each cube of a fine grid count as one at first, then each for itself for a few passes.
    """
    extent = float(np.ptp(points, axis=0).max())
    groups, masses = condensed(points, areas)
    centres = lloyd_iterations(_nearest(groups, masses), centres, extent)
    return (
        centres
        if groups is points
        else lloyd_iterations(_nearest(points, areas), centres, extent, LAST_PASSES)
    )


def lloyd_iterations(held: Held, centres: FloatArray, extent: float, passes: int = PASSES) -> FloatArray:
    """Return the centres (n, 3) after moving each to the mean of what it holds, until all are still.

    held: what given centres hold; one that holds nothing stays. extent: of all places, which says what is still.
    passes: at most this many.
    """
    for _ in range(passes):
        sums, mass = held(centres)
        moved = np.where(mass[:, None] > 0.0, sums / np.where(mass, mass, 1.0)[:, None], centres)
        step, centres = float(np.abs(moved - centres).max()), moved
        if step <= STILL * extent:
            break
    return centres


def _nearest(points: FloatArray, areas: FloatArray) -> Held:
    def held(centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        region = assign(points, centres, np.zeros(len(centres)))
        mass = np.bincount(region, areas, len(centres)).astype(np.float64)
        return np.stack([np.bincount(region, areas * axis, len(centres)) for axis in points.T], axis=1), mass

    return held

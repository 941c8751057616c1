"""Map segmentation: regions around salient points with equal shares of both halves (paper eq. 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import FloatArray, IntArray
from meshmark.segmentation.centres import converged_centres
from meshmark.segmentation.power_diagram import assign, balanced_weights

__all__ = ["Regions", "choose_seeds", "default_regions", "halves", "map_regions"]

LEAST_HALF = 0.2
"""A plane that leaves less than this share of the area on one side does not split a model into two halves."""
MOST_REGIONS = 32


@dataclass(frozen=True, eq=False, kw_only=True)
class Regions:
    """A map of n regions, each of a green and a blue part.

    region:      (p,) index of the region of each point.
    green:       (p,) whether the point lies in the green (top) half.
    green_share: (n,) part of the green area that lies in each region; 1/n each is perfect.
    blue_share:  (n,) the same of the blue area.
    """

    region: IntArray
    green: NDArray[np.bool_]
    green_share: FloatArray
    blue_share: FloatArray

    @property
    def balance(self) -> float:
        """Largest share over mean share, of both colours; 1 is perfect."""
        return float(max(self.green_share.max(), self.blue_share.max()) * len(self.green_share))


def default_regions(points: int) -> int:
    """Return how many regions a model of `points` points is split into: 2 to 32, as the root of its size."""
    return int(np.clip(round(points**0.5 / 8.0), 2, MOST_REGIONS))


def choose_seeds(points: FloatArray, beta: FloatArray, salient: IntArray, count: int) -> IntArray:
    """Return `count` salient points, strong and far apart: each maximises beta^(1/4) times the distance to
    the seeds before it. Where there are too few salient points, others of the surface make up the number.

    The exponent is measured: the whole beta gives regions a tenth less compact, none at all weak seeds.
    """
    pool, worth = salient, beta[salient]
    if len(salient) < count:
        pool = np.arange(len(points))
        worth = np.full(len(points), 1e-6 * float(worth.min(initial=1.0)))
        worth[salient] = beta[salient]
    worth = worth**0.25
    places = points[pool]
    reach = np.ones(len(pool))
    seeds = np.empty(count, np.int64)
    for i in range(count):
        seeds[i] = chosen = int(np.argmax(worth * reach))
        gap = places - places[chosen]
        away = np.sqrt(np.einsum("ij,ij->i", gap, gap))
        reach = np.minimum(reach, away) if i else away
    return pool[seeds]


def halves(canonical: FloatArray, areas: FloatArray) -> NDArray[np.bool_]:
    """Return (p,): which points lie in the green half, on the positive side of the principal plane.

    canonical: (p, 3) canonical coordinates. The plane goes through the centroid, normal to the principal axis of
    least extent along which both sides hold a fair part of the area.
    """
    green = canonical > 0.0
    share = areas @ green / areas.sum()
    fair = (np.minimum(share, 1.0 - share) >= LEAST_HALF) & (np.ptp(canonical, axis=0) > 1e-6)
    axis = int(np.flatnonzero(fair)[-1]) if fair.any() else 0
    return green[:, axis]


def map_regions(points: FloatArray, faces: IntArray, seeds: IntArray) -> Regions:
    """Return the map of regions around the points `seeds` (n,).

    From the seeds the centres of the regions converge by k-means, which makes up for seeds that an attack moves
    (docs/decisions/0012). In each half a power diagram over the centres gives every region 1/n of the area of that
    half, as compactly as can be (docs/design.md, section 3).

    Parameters
    ----------
    points : (p, 3) array of float
        Positions; coincident vertices are one point.
    faces : (m, 3) array of int
        Triangles, indices into `points`.
    seeds : (n,) array of int
        Points at which the centres of the regions start.

    Returns
    -------
    Regions
        Region and half of each point (p,), and each region's share (n,) of the area of both halves.

    Raises
    ------
    InputError
        The faces have no area.
    """
    areas = vertex_areas(points, faces)
    points = canonical_frame(points, faces).to_canonical(points)  # groups of points turn with the model
    green = halves(points, areas)
    region = np.empty(len(points), np.int64)
    shares = []
    at = converged_centres(points, areas, points[seeds])
    for half in (green, ~green):
        mass = areas[half]
        inside = points[half]
        weights = balanced_weights(inside, mass, at) if mass.any() else np.zeros(len(seeds))
        region[half] = assign(inside, at, weights)
        held = np.bincount(region[half], weights=mass, minlength=len(seeds))
        shares.append(held / (held.sum() or 1.0))
    return Regions(region=region, green=green, green_share=shares[0], blue_share=shares[1])

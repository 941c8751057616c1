"""The code in every region of the surface: norms about the region's own centroid, one vote for each region."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.areas import face_areas
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.registration.surfels import low_passed
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.rivals.cho import norm_margins, shifted_norms
from meshmark.research.schemes.rivals.histogram import MEAN
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.rivals.tuning import strongest
from meshmark.research.schemes.rivals.voronoi import clusters, edge_lengths, regions
from meshmark.research.schemes.scheme import Bits

__all__ = ["Regional"]

# The regions of a marked model differ a little from those it was marked in. So often they are sought again, and
# then so large a share of the budget is used, until the reader sees every bit.
ROUNDS, SHARES = 3, (1.0, 0.6, 0.3)
LARGEST, SMALLEST = 0.25, 1e-4
# Points for each code bit, without which no region has enough in each bin.
FEWEST = 6
# The salient points are those of the model after a Gaussian of this width, in RMS distances from its centroid.
SMOOTH = 0.06
# Of a region's norms this share at either end is left out: a few points that change regions would move all bins.
TRIM = 0.02


@dataclass(frozen=True)
class Regional(Rival):
    """Cho's mean in each geodesic Voronoi region of the salient points that a detector finds.

    pairs: number of eigenfunctions that the detector looks at, within `rings` rings of a point; least, most: number
    of regions, one for each salient point; apart: salient points within this distance, in roots of the area, are
    one.
    """

    pilots: int = 16
    pairs: int = 10
    rings: int = 2
    least: int = 2
    most: int = 5
    apart: float = 0.1

    def total(self, votes: FloatArray) -> float:
        """Return how salient a cluster of points with these votes (n,) is."""
        return float(votes.sum())

    @abstractmethod
    def votes(self, host: Host) -> FloatArray:
        """Return (p,): how salient each point is, 0 for those that are not."""

    def regions(self, host: Host) -> IntArray:
        """Return for each point (p,) the row of the salient spot in whose region it is, most salient first.

        Raises `CapacityError` where the model has no salient point.
        """
        smooth = _smoothed(host)
        lengths = edge_lengths(smooth)
        cluster, sums = clusters(lengths, self.votes(smooth), self.apart * _extent(smooth), self.total)
        if not len(sums):
            raise CapacityError(f"{self.title} finds no salient point on the model, expected at least one")
        kept = _clear_cut(sums, self.least, self.most)
        return regions(smooth, lengths, np.where(cluster < kept, cluster, -1))

    def _placed(self, host: Host, code: Bits, _key: Key, budget: float) -> FloatArray:
        if len(host.points) < FEWEST * len(code):
            raise CapacityError(
                f"the model has {len(host.points)} points, {self.title} needs at least {FEWEST * len(code)}"
            )
        region = self.regions(host)
        best, least_wrong = host.points, len(code) + 1
        for share in SHARES:
            for _ in range(ROUNDS):
                try:
                    points = _strongest(host, region, code, share * budget)
                except CapacityError:
                    return best
                region = self.regions(host.with_points(points))
                wrong = int((_vote(points, region, len(code)) * (2.0 * code - 1.0) <= 0.0).sum())
                if wrong < least_wrong:
                    best, least_wrong = points, wrong
                if not wrong:
                    return best
        return best

    def _seen(self, host: Host, _key: Key, _reference: Any) -> tuple[FloatArray, int]:
        return -_vote(host.points, self.regions(host), self._length), 1


def _clear_cut(sums: FloatArray, least: int, most: int) -> int:
    """Return how many salient points to keep, so that the first left out has far fewer votes than the last kept."""
    falls = -np.diff(sums[least - 1 : most + 1])
    return least + int(np.argmax(falls)) if len(falls) else len(sums)


def _smoothed(host: Host) -> Host:
    """Return the host on a copy of the model where neither the mark nor a little noise moves the salient points."""
    width = SMOOTH * canonical_frame(host.points, host.faces).scale
    return host.with_points(low_passed(host.points, host.faces, width))


def _extent(host: Host) -> float:
    return float(np.sqrt(face_areas(host.points, host.faces).sum()))


def _strongest(host: Host, region: IntArray, code: Bits, budget: float) -> FloatArray:
    def place(margin: float) -> FloatArray:
        return _shifted(host.points, region, code, margin)

    return strongest(place, host.rms, budget, SMALLEST, LARGEST)[1]


def _shifted(points: FloatArray, region: IntArray, code: Bits, margin: float) -> FloatArray:
    placed = points.copy()
    for row in range(int(region.max()) + 1):
        inside = region == row
        if inside.any():
            placed[inside] = shifted_norms(points[inside], code, MEAN, margin, TRIM)
    return placed


def _vote(points: FloatArray, region: IntArray, count: int) -> FloatArray:
    """Return (count,): votes of the regions for 1 minus those for 0; a draw goes by the sum of the margins."""
    inside = (points[region == row] for row in range(int(region.max()) + 1))
    margins = np.array([norm_margins(part, count, MEAN, TRIM) for part in inside if len(part)])
    return np.asarray(np.sign(margins).sum(axis=0) + 0.5 * np.tanh(margins.sum(axis=0)))

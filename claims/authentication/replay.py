"""An attacker's replay: a marked point and its ring, copied from elsewhere with the marks in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.rings import ordered_rings
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Replay"]


class Replay:
    """Lays a ring of `source` around a marked point, with that point, over one of as many neighbours.

    It is turned, scaled and moved to where it fits best, beginning at any neighbour; so all that the mark's MAC is
    made from is as it was, but for the place.
    """

    def __init__(self, target: Surface, source: Surface, marks: NDArray[np.bool_]) -> None:
        self.rings = _by_point(target)
        self.points = source.points
        self.sources: dict[int, list[IntArray]] = {}
        for point, ring in _by_point(source).items():
            if marks[point]:
                self.sources.setdefault(len(ring), []).append(np.append(ring, point))

    def __call__(self, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
        """Change `points` (p, 3) around `place`; False where there is no ring to replay there."""
        ring = self.rings.get(place)
        if ring is None or len(ring) not in self.sources:
            return False
        choices = self.sources[len(ring)]
        chosen = choices[int(rng.integers(len(choices)))]
        if chosen[-1] == place and self.points.shape == points.shape:
            return False
        source = np.append(np.roll(chosen[:-1], int(rng.integers(len(ring)))), chosen[-1])
        target = np.append(ring, place)
        points[target] = _fitted(self.points[source], points[target])
        return True


def _by_point(surface: Surface) -> dict[int, IntArray]:
    """Return the points around each one inside the surface, in order."""
    groups = ordered_rings(surface.faces, len(surface.points))
    inside = np.ones(len(surface.points), bool)
    for group in groups:
        inside[group.around[group.boundary]] = False
    return {
        int(point): ring
        for group in groups
        for point, ring in zip(group.vertex, group.around, strict=True)
        if inside[point] and inside[ring].all()
    }


def _fitted(source: FloatArray, target: FloatArray) -> FloatArray:
    """Return `source` (k, 3) turned, scaled and moved to where it is nearest to `target` (Umeyama 1991)."""
    middle, goal = source.mean(axis=0), target.mean(axis=0)
    u, sizes, vt = np.linalg.svd((target - goal).T @ (source - middle))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    turn = (u * sign) @ vt
    scale = float(sizes @ sign) / float(((source - middle) ** 2).sum())
    return np.asarray(goal + scale * (source - middle) @ turn.T)

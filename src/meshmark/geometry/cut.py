"""The plane by which a part of a surface was cut off: where open edges lie and everything is on one side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.open_edges import open_edges
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Cut", "find_cut"]

# Fewer open edges than this are a hole, not a cut.
FEWEST_EDGES = 8
# Triples of open edges through which planes are tried, and points and open edges by which a plane is judged.
TRIPLES = 1500
JUDGES = 3000
# A cut is ragged: open edges lie within this many median edges of its plane, and hardly a point lies beyond it.
RAGGED = 1.5
BEYOND, BEYOND_SHARE = 2.0, 0.002
# The faces at a cut end there, so they lead across its plane: by this cosine, in the mean over its border. In
# polygon soups open edges lie along any plane, but their faces mostly lie in it.
ACROSS = 0.3
# Nearly all of a flat model lies close to some plane; of a part that was cut at most this share does.
MOST_NEAR = 0.3
# An edge at which a face leads across the plane by less than this is none of the cut's.
WITHIN = 0.1
REFINEMENTS = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Cut:
    """A planar cut.

    normal: (3,) unit vector towards what is gone; centre: (3,) and spread (3, 3): mean and covariance of the
    border, by length; length: of the border; area: that it encloses in the plane.
    """

    normal: FloatArray
    centre: FloatArray
    spread: FloatArray
    length: float
    area: float

    @property
    def radius(self) -> float:
        """How wide the cut is: the radius of a circle of its length, or of its area if that is more."""
        return float(max(self.length / (2.0 * np.pi), np.sqrt(self.area / np.pi)))


def find_cut(points: FloatArray, faces: IntArray) -> Cut | None:
    """Return the plane with the longest border along it and the whole surface on one side, or None."""
    start, end, way = open_edges(faces, len(points))
    if len(start) < FEWEST_EDGES:
        return None
    one, other = points[start], points[end]
    length = np.sqrt(((other - one) ** 2).sum(axis=1))
    edge = float(np.median(np.sqrt(((points[faces[:, 0]] - points[faces[:, 1]]) ** 2).sum(axis=1))))
    middle = (one + other) / 2.0
    outward = _outward(points, faces, start, end)
    found = _best_plane(points[np.unique(faces)], middle, length, outward, edge)
    if found is None:
        return None
    normal, centre = found
    for _ in range(REFINEMENTS):
        near = (np.abs((middle - centre) @ normal) < RAGGED * edge) & (outward @ normal > WITHIN * length)
        if not near.any():  # the border lies in another plane than the three edges gave
            return None
        weight = length[near] / length[near].sum()
        centre = weight @ middle[near]
        arm = middle[near] - centre
        spread = (arm * weight[:, None]).T @ arm
        flattest = np.linalg.eigh(spread)[1][:, 0]
        normal = flattest if flattest @ normal > 0.0 else -flattest
    turns = np.sign(way[near, None]) * np.cross(one[near] - centre, other[near] - centre)
    area = 0.5 * float(np.linalg.norm(turns.sum(axis=0)))
    return Cut(normal=normal, centre=centre, spread=spread, length=float(length[near].sum()), area=area)


def _outward(points: FloatArray, faces: IntArray, start: IntArray, end: IntArray) -> FloatArray:
    """Return (e, 3): the directions in which the faces end at open edges, times the edges' lengths.

    Those of several faces at one edge are added: they cancel where a flat surface only changes its side.
    """
    count = len(points)
    corners = np.concatenate([np.roll(faces, -k, axis=1) for k in range(3)])
    one, other, third = corners.T
    name = np.minimum(one, other) * count + np.maximum(one, other)
    wanted = start * count + end
    order = np.argsort(wanted)
    row = np.minimum(np.searchsorted(wanted, name, sorter=order), len(wanted) - 1)
    here = wanted[order[row]] == name
    along = points[other[here]] - points[one[here]]
    size = np.maximum((along * along).sum(axis=1), np.finfo(float).tiny)[:, None]
    inward = points[third[here]] - points[one[here]]
    inward -= (inward * along).sum(axis=1)[:, None] / size * along
    width = np.sqrt((inward * inward).sum(axis=1))[:, None]
    way = -inward / np.where(width > 0.0, width, 1.0) * np.sqrt(size)
    edge = order[row[here]]
    return np.stack([np.bincount(edge, axis, len(start)) for axis in way.T], axis=1)


def _best_plane(
    points: FloatArray, middle: FloatArray, length: FloatArray, outward: FloatArray, edge: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return normal (3,) and a place (3,) of the plane through three open edges at which most surface ends."""
    rng = np.random.default_rng(0)  # the same planes every time
    judges = points if len(points) <= JUDGES else points[rng.choice(len(points), JUDGES, replace=False)]
    if not length.sum() > 0.0:
        return None
    if len(length) > JUDGES:
        some = rng.choice(len(length), JUDGES, replace=False)
        middle, length, outward = middle[some], length[some], outward[some]
    a, b, c = middle[rng.choice(len(middle), (TRIPLES, 3), p=length / length.sum())].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    size = np.sqrt((normal * normal).sum(axis=1))
    wide = size > 4.0 * edge * edge  # flatter triples say little of the direction
    if not wide.any():
        return None
    normal, place = normal[wide] / size[wide, None], a[wide]
    level = np.einsum("ij,ij->i", normal, place)
    height = judges @ normal.T - level
    above, below = (height > BEYOND * edge).mean(axis=0), (height < -BEYOND * edge).mean(axis=0)
    near = (np.abs(middle @ normal.T - level) < RAGGED * edge).astype(np.float64)
    normal *= np.where(above <= below, 1.0, -1.0)[:, None]
    across = np.einsum("ip,pi->p", outward.T @ near, normal)
    likely = (np.minimum(above, below) <= BEYOND_SHARE) & (1.0 - above - below <= MOST_NEAR)
    likely &= near.sum(axis=0) >= FEWEST_EDGES
    worth = across * (likely & (across > ACROSS * (length @ near)))
    best = int(np.argmax(worth))
    return (normal[best], place[best]) if worth[best] > 0.0 else None

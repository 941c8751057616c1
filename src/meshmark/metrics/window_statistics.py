"""The local term of MSDM2: mean, contrast and pattern of two curvature fields in a window on the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.growth import Growth, HalfEdges
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Fields", "local_values"]

STRUCTURE = 0.5  # weight of the pattern's term beside 1 for mean and 1 for contrast
REGULAR = 1.0  # added to each denominator


@dataclass(frozen=True, eq=False, kw_only=True)
class Fields:
    """Per radius: curvature `own` (k, p) of the judged surface and `theirs` (k, p), that of the original at the
    matched points; `matched` (p, 3) the positions of those.
    """

    own: FloatArray
    theirs: FloatArray
    matched: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class _Samples:
    """Flat lists of what lies in the windows: owner, both values, squared distances on both surfaces."""

    owner: IntArray
    own: FloatArray
    theirs: FloatArray
    squared: FloatArray
    matched_squared: FloatArray


def local_values(growth: Growth, graph: HalfEdges, fields: Fields, level: int, radius: float) -> FloatArray:
    """Return (c,): (L + C + 0.5 S) / 2.5 for the window of each centre, 0 for equal fields.

    A window holds the points in the sphere, and where edges leave it, values interpolated along them.
    """
    both = [_points_inside(growth, fields, level, radius), _crossings(growth, graph, fields, level, radius)]
    owner = np.concatenate([s.owner for s in both])
    x, y = np.concatenate([s.own for s in both]), np.concatenate([s.theirs for s in both])
    scale = -2.0 / (radius * radius)  # Gaussian of half the radius
    w = np.exp(scale * np.concatenate([s.squared for s in both]))
    v = np.exp(scale * np.concatenate([s.matched_squared for s in both]))

    def total(values: FloatArray) -> FloatArray:
        return np.bincount(owner, values, minlength=len(growth.centres)).astype(np.float64, copy=False)

    sum_w, sum_v = total(w), total(v)
    mean_x, mean_y = total(w * x) / sum_w, total(v * y) / sum_v
    x -= mean_x.take(owner)
    y -= mean_y.take(owner)
    deviation_x, deviation_y = np.sqrt(total(w * x * x) / sum_w), np.sqrt(total(v * y * y) / sum_v)
    # Weights of one side over the sum of the other: so the reference values are made.
    covariance = total(v * x * y) / sum_w
    product = deviation_x * deviation_y
    mean = np.abs(mean_x - mean_y) / (np.maximum(mean_x, mean_y) + REGULAR)
    contrast = np.abs(deviation_x - deviation_y) / (np.maximum(deviation_x, deviation_y) + REGULAR)
    pattern = np.abs(product - covariance) / (product + REGULAR)
    local: FloatArray = (mean + contrast + STRUCTURE * pattern) / (2.0 + STRUCTURE)
    return local


def _points_inside(growth: Growth, fields: Fields, level: int, radius: float) -> _Samples:
    inside = np.flatnonzero(growth.squared <= radius * radius)
    owner, point = growth.owner.take(inside), growth.point.take(inside)
    apart = fields.matched.take(point, axis=0) - fields.matched.take(growth.centres.take(owner), axis=0)
    return _Samples(
        owner=owner,
        own=fields.own[level].take(point),
        theirs=fields.theirs[level].take(point),
        squared=growth.squared.take(inside),
        matched_squared=np.einsum("ij,ij->i", apart, apart),
    )


def _crossings(growth: Growth, graph: HalfEdges, fields: Fields, level: int, radius: float) -> _Samples:
    leaving = np.flatnonzero((growth.near <= radius * radius) & (growth.far > radius * radius))
    share = growth.crossing(graph, radius, leaving)
    half_edge, owner = growth.half_edge.take(leaving), growth.edge_owner.take(leaving)
    start, end = graph.start.take(half_edge), graph.end.take(half_edge)
    own, theirs = fields.own[level], fields.theirs[level]
    apart = (1.0 - share)[:, None] * fields.matched.take(start, axis=0)
    apart += share[:, None] * fields.matched.take(end, axis=0)
    apart -= fields.matched.take(growth.centres.take(owner), axis=0)
    return _Samples(
        owner=owner,
        own=(1.0 - share) * own.take(start) + share * own.take(end),
        theirs=(1.0 - share) * theirs.take(start) + share * theirs.take(end),
        squared=np.full(len(share), radius * radius),
        matched_squared=np.einsum("ij,ij->i", apart, apart),
    )

"""By which map one part of a surface was a copy of another one, of which a piece was changed or cut away since."""

from __future__ import annotations

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.affine import Affine
from meshmark.geometry.congruence import Tolerance, fit_affine
from meshmark.geometry.connected import Parts
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray

__all__ = ["partial_congruence"]

# A copy is proved by at least this many points that stayed, and this share of all.
_FEWEST, _SHARE = 24, 0.4
# Maps from three pairs that are tried, and how often the best one is fitted anew to what it explains.
_TRIES, _PASSES = 24, 3
# Rings are alike whose lengths, over their mean, differ by less than _ALIKE, and by less than the next best ring's
# difference divided by _CLEARLY.
_ALIKE, _CLEARLY = 1e-3, 4.0
# Neighbours of a point that are compared.
_RING = 8


def partial_congruence(
    points: FloatArray, parts: Parts, ends: tuple[int, int], tolerance: Tolerance
) -> Affine | None:
    """Return the map of the first of two parts to the second that suits most of the second, None without any.

    Points in the same order are compared where there are equally many, else points with rings that are alike.
    """
    one, other = (points[parts.points(end)] for end in ends)
    most = float(tolerance(points, parts.size[[ends[1]]])[0])
    if (parts.counts[ends[0]] == parts.counts[ends[1]]).all():
        found = _consensus(one, other, most)
        if found is not None and _suits(found, one, other, most):
            return found
    pairs = _alike_rings((one, parts.faces(ends[0])), (other, parts.faces(ends[1])))
    found = _consensus(one[pairs[:, 0]], other[pairs[:, 1]], most)
    return found if found is not None and _suits(found, one, other, most) else None


def _suits(affine: Affine, one: FloatArray, other: FloatArray, most: float) -> bool:
    near = np.asarray(kd_tree(affine(one)).query(other)[0]) <= most
    return int(near.sum()) >= max(_FEWEST, _SHARE * len(other))


def _consensus(one: FloatArray, other: FloatArray, most: float) -> Affine | None:
    """Return the map that brings most of the pairs (n, 3) together, fitted to these."""
    count = len(one)
    if count < _FEWEST:
        return None
    best, held = None, np.zeros(count, bool)
    for number in range(_TRIES):
        # Pairs far apart in the list, without drawing any: strides that have no common pattern.
        rows = (np.arange(4) * (count // 4) + number * 7919 * (1 + np.arange(4))) % count
        found = _fitted(one[rows], other[rows])
        if found is None:
            continue
        near = _off(found, one, other) <= 4.0 * most
        if near.sum() > held.sum():
            best, held = found, near
            if held.sum() > 0.9 * count:
                break
    for _ in range(_PASSES):
        if best is None or held.sum() < _FEWEST:
            return None
        best = _fitted(one[held], other[held])
        held = held if best is None else _off(best, one, other) <= most
    return best


def _fitted(one: FloatArray, other: FloatArray) -> Affine | None:
    try:
        return fit_affine(one, other)
    except InputError:  # all in one point
        return None


def _off(affine: Affine, one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(affine(one) - other, axis=1))


def _alike_rings(one: tuple[FloatArray, IntArray], other: tuple[FloatArray, IntArray]) -> IntArray:
    """Return (n, 2): points of two surfaces, each with points and faces, whose rings are alike."""
    held, first = _rings(*one)
    wanted, second = _rings(*other)
    if len(held) < 2 or not len(wanted):
        return np.empty((0, 2), np.int64)
    off, found = (np.asarray(item) for item in kd_tree(held).query(wanted, k=2))
    clear = (off[:, 0] < _ALIKE) & (off[:, 1] > _CLEARLY * off[:, 0])
    return np.stack([first[found[clear, 0]], second[clear]], axis=1)


def _rings(points: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return (r, 9): of points with up to eight neighbours the falling distances over their mean; and the points.

    The last of the nine is the number of neighbours.
    """
    edges = unique_edges(faces)
    ends = np.concatenate([edges, edges[:, ::-1]])
    length = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    order = np.lexsort((-length, ends[:, 0]))
    held = np.bincount(ends[:, 0], minlength=len(points))
    total = np.bincount(ends[:, 0], length, len(points))
    rows = np.flatnonzero((held >= 3) & (held <= _RING) & (total > 0.0))
    start = np.concatenate([[0], np.cumsum(held)])[rows]
    table = np.zeros((len(rows), _RING + 1))
    sorted_length = length[order]
    for place in range(_RING):
        there = held[rows] > place
        table[there, place] = sorted_length[start[there] + place]
    table[:, :_RING] *= (held[rows] / total[rows])[:, None]
    table[:, _RING] = held[rows]
    return table, rows

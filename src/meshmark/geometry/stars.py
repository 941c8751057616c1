"""How much a point is held by the faces around it, its star: in which directions it slides along the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.areas import cross_by_axis
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Stars", "are_midpoints", "stars_of"]

# Twice the area of a face over the square of its longest edge, at least, for its normal to be one.
SLIVER = 1e-9
# Angles around a point, at least, in radians, by which the tensor is divided.
LEAST_ANGLE = 1e-3
# A point with more neighbours is not looked at for midpoints.
MOST_NEIGHBOURS = 64
# The different entries of a symmetric matrix, and which of them is where.
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_WHOLE = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


@dataclass(frozen=True, eq=False, kw_only=True)
class Stars:
    """The stars of p points.

    tensor: (p, 3, 3) symmetric, without unit: how much a motion along a direction leaves the surface, 0 along a
    plane and along a straight crease or border. height: (p,) the smallest height of a triangle of the star, in the
    unit of the points, 0 where there is none. used: (p,) which points have a star.
    """

    tensor: FloatArray
    height: FloatArray
    used: NDArray[np.bool_]


def stars_of(points: FloatArray, faces: IntArray) -> Stars:
    """Measure the star of each point.

    The tensor is the mean of n n' over the angles of the faces at the point, n their normals, plus that of b b'
    over its edges, b the sum of the directions from the edge into its faces: 0 inside a plane, along the fold of a
    crease, outwards at a border. It depends neither on the winding of faces nor on how a plane is split into them.

    Parameters
    ----------
    points : (p, 3) float array
    faces : (m, 3) int array
        Of three different points each.

    Returns
    -------
    Stars
    """
    count, corner = len(points), np.ascontiguousarray(faces.T)
    # By coordinate, corner and face, the faces last; an edge leads from each corner to the next.
    ends = np.stack([axis.take(corner) for axis in np.ascontiguousarray(points.T)])
    edges = np.roll(ends, -1, axis=1) - ends
    normals = cross_by_axis(edges[:, 0], edges[:, 1])
    double = _length(normals)
    lengths = _length(edges)
    longest = np.maximum(lengths.max(axis=0), 1e-300)
    sound = double > SLIVER * longest**2
    normals = np.where(sound, normals / np.maximum(double, 1e-300), 0.0)
    tensor = np.zeros((len(_PAIRS), count))
    total = np.zeros(count)
    outer = _squares(normals)
    for place in range(3):
        across = -(edges[:, place] * edges[:, place - 1])
        angle = np.arctan2(double, across[0] + across[2] + across[1]) * sound
        total += np.bincount(corner[place], angle, count)
        _add(tensor, corner[place], outer * angle)
    joined, inward = _inward(faces, edges / np.maximum(lengths, 1e-300), normals)
    for end in joined:
        _add(tensor, end, _squares(inward))
    tensor /= np.maximum(total, LEAST_ANGLE)
    height = np.full(count, np.inf)
    for own in corner:
        np.minimum.at(height, own[sound], (double / longest)[sound])
    height[np.isinf(height)] = 0.0
    return Stars(tensor=np.ascontiguousarray(tensor.T)[:, _WHOLE], height=height, used=total > 0.0)


def _inward(faces: IntArray, along: FloatArray, normals: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the ends (2, e) of the edges, and the sum (3, e) of the unit vectors from each into its faces."""
    count = int(faces.max(initial=-1)) + 1
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    name = np.minimum(start, end) * count + np.maximum(start, end)
    names, row = np.unique(name, return_inverse=True)
    # Face by face, as the names are.
    into = [each.T.ravel() for each in cross_by_axis(normals[:, None], along)]
    summed = np.stack([np.bincount(row.ravel(), axis, len(names)) for axis in into]).astype(float)
    return np.stack([names // max(count, 1), names % max(count, 1)]).astype(np.int64), summed


def _length(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors whose coordinates come first."""
    x, y, z = vectors
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _squares(vectors: FloatArray) -> FloatArray:
    """Return (6, n): the different entries of v v' of each vector (3, n)."""
    return np.stack([vectors[i] * vectors[j] for i, j in _PAIRS])


def _add(sums: FloatArray, rows: IntArray, values: FloatArray) -> None:
    for total, own in zip(sums, values, strict=True):
        total += np.bincount(rows, own, len(total))


def are_midpoints(points: FloatArray, edges: IntArray, tolerance: float) -> NDArray[np.bool_]:
    """Return (p,): which points lie in the middle between two of their neighbours, up to `tolerance`.

    Such points come from a subdivision: what another tool adds or leaves out.

    Parameters
    ----------
    points : (p, 3) float array
    edges : (e, 2) int array
        Each undirected edge once.
    tolerance : float
        In the unit of the points.
    """
    count = len(points)
    ends = np.concatenate([edges, edges[:, ::-1]])
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    first = np.searchsorted(ends[:, 0], np.arange(count + 1))
    degree = np.diff(first)
    middle = np.zeros(count, bool)
    for number in np.unique(degree):
        if not 2 <= number <= MOST_NEIGHBOURS:
            continue
        rows = np.flatnonzero(degree == number)
        neighbours = ends[first[rows][:, None] + np.arange(number), 1]
        arms = points[neighbours] - points[rows][:, None]
        gaps = ((arms[:, :, None] + arms[:, None, :]) ** 2).sum(axis=-1)
        gaps[:, np.arange(number), np.arange(number)] = np.inf
        middle[rows] = (gaps < (2.0 * tolerance) ** 2).any(axis=(1, 2))
    return middle

"""How much a point is held by the faces around it, its star: in which directions it slides along the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["Stars", "are_midpoints", "stars_of"]

# Twice the area of a face over the square of its longest edge, at least, for its normal to be one.
SLIVER = 1e-9
# Angles around a point, at least, in radians, by which the tensor is divided.
LEAST_ANGLE = 1e-3
# A point with more neighbours is not looked at for midpoints.
MOST_NEIGHBOURS = 64


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
    count = len(points)
    corners = points[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(edges[:, 0], edges[:, 1])
    double = np.linalg.norm(normals, axis=1)
    lengths = np.linalg.norm(edges, axis=2)
    longest = np.maximum(lengths.max(axis=1), 1e-300)
    sound = double > SLIVER * longest**2
    normals = np.where(sound[:, None], normals / np.maximum(double, 1e-300)[:, None], 0.0)
    tensor = np.zeros((count, 9))
    total = np.zeros(count)
    outer = _squares(normals)
    for corner in range(3):
        across = np.einsum("ij,ij->i", edges[:, corner], -edges[:, corner - 1])
        angle = np.arctan2(double, across) * sound
        total += np.bincount(faces[:, corner], angle, count)
        _add(tensor, faces[:, corner], outer * angle[:, None])
    ends, inward = _inward(faces, edges / np.maximum(lengths, 1e-300)[:, :, None], normals)
    for end in ends.T:
        _add(tensor, end, _squares(inward))
    tensor /= np.maximum(total, LEAST_ANGLE)[:, None]
    height = np.full(count, np.inf)
    for corner in range(3):
        np.minimum.at(height, faces[sound, corner], (double / longest)[sound])
    height[np.isinf(height)] = 0.0
    return Stars(tensor=tensor.reshape(-1, 3, 3), height=height, used=total > 0.0)


def _inward(faces: IntArray, along: FloatArray, normals: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the ends (e, 2) of the edges, and the sum (e, 3) of the unit vectors from each into its faces."""
    count = int(faces.max(initial=-1)) + 1
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    name = np.minimum(start, end) * count + np.maximum(start, end)
    into = np.cross(np.repeat(normals, 3, axis=0), along.reshape(-1, 3))
    names, row = np.unique(name, return_inverse=True)
    summed = np.stack([np.bincount(row.ravel(), axis, len(names)) for axis in into.T], axis=1).astype(float)
    ends = np.stack([names // max(count, 1), names % max(count, 1)], axis=1).astype(np.int64)
    return ends, summed


def _squares(vectors: FloatArray) -> FloatArray:
    """Return (n, 9): v v' of each vector (n, 3)."""
    return (vectors[:, :, None] * vectors[:, None, :]).reshape(-1, 9)


def _add(sums: FloatArray, rows: IntArray, values: FloatArray) -> None:
    for column in range(sums.shape[1]):
        sums[:, column] += np.bincount(rows, values[:, column], len(sums))


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

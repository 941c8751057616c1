"""Plane parts of a surface, and how plane they still are once their points have moved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from meshmark.arrays import sorted_distinct
from meshmark.geometry.areas import area_vectors
from meshmark.geometry.blocks import blocks
from meshmark.geometry.components import connected_components
from meshmark.geometry.extent import used_points
from meshmark.geometry.face_neighbours import face_neighbours
from meshmark.mesh import FloatArray, IntArray

__all__ = ["PlanePatches", "spreads"]

# Faces are in one plane where the cosine of the angle between them is off 1 by at most this, and a patch of them is
# plane where its points are off their plane by at most this share of the diagonal, RMS.
_ANGLE, _OFF = 1e-6, 1e-7
# Fewer points always lie in a plane.
_LEAST = 4
# The points of a patch of this RMS radius over the diagonal are as plane on a sphere as large as the model.
# On meshes of more than this number of points smaller ones are everywhere, and say nothing.
_RADIUS, _FINE = 6e-4, 1_000_000


@dataclass(frozen=True, eq=False, kw_only=True)
class PlanePatches:
    """Connected plane patches of four points and more.

    point, patch: (n,) each, the points of the patches and the number of the patch that each is in; a point on an
    edge between two is in both. points: (p,) which of the surface's points these are. share: of the surface's area,
    0 to 1. diagonal: of the box around the surface, in the unit of its points.
    """

    point: IntArray
    patch: IntArray
    points: NDArray[np.bool_]
    share: float
    diagonal: float

    @classmethod
    def of(cls, points: FloatArray, faces: IntArray) -> PlanePatches:
        """Find the plane patches of a surface.

        Parameters
        ----------
        points : (p, 3) float array
        faces : (m, 3) int array

        Returns
        -------
        PlanePatches
        """
        points, diagonal = _in_unit_box(points, faces)
        normals = area_vectors(points, faces)
        area = np.linalg.norm(normals, axis=1)
        normals /= np.maximum(area, np.finfo(float).tiny)[:, None]
        one, other, _ = face_neighbours(faces, len(points))
        flat = np.empty(len(one), bool)
        for part in blocks(len(one)):
            cosine = np.einsum("ij,ij->i", normals[one[part]], normals[other[part]])
            flat[part] = 1.0 - np.abs(cosine) <= _ANGLE
        del normals
        size = (len(faces), len(faces))
        graph = coo_array((np.ones(int(flat.sum()), np.int8), (one[flat], other[flat])), shape=size)
        del one, other, flat
        label = connected_components(graph)[1]
        beside = np.flatnonzero(np.bincount(label)[label] > 1)  # one face has too few points
        names, label = np.unique(label[beside], return_inverse=True)
        count = len(names)
        # Each point of each patch once.
        code = sorted_distinct(np.repeat(label, 3) * len(points) + faces[beside].ravel())
        pairs = np.stack(np.divmod(code, max(len(points), 1)), axis=1)
        sizes = np.bincount(pairs[:, 0], minlength=count)
        places = points[pairs[:, 1]]
        off = np.sqrt(_square_off(places, pairs[:, 0], count) / np.maximum(sizes, 1))
        kept = (sizes >= _LEAST) & (off <= _OFF)
        if len(points) > _FINE:
            kept &= _radius(places, pairs[:, 0], count) >= _RADIUS
        rows = kept[pairs[:, 0]]
        share = float(area[beside[kept[label]]].sum() / max(area.sum(), np.finfo(float).tiny))
        inside = np.zeros(len(points), bool)
        inside[pairs[rows, 1]] = True
        return cls(point=pairs[rows, 1], patch=pairs[rows, 0], points=inside, share=share, diagonal=diagonal)

    def off_plane(self, points: FloatArray) -> float:
        """Return the RMS distance of moved points (p, 3) from the plane fitted to each patch; 0 without patches."""
        if not len(self.point):
            return 0.0
        places = points[self.point] / self.diagonal
        square = _square_off(places, self.patch, int(self.patch.max()) + 1)
        return float(np.sqrt(square.sum() / len(self.point))) * self.diagonal


def _radius(places: FloatArray, patch: IntArray, count: int) -> FloatArray:
    """Return (count,): the RMS distance of places (n, 3) from the middle of each patch (n,)."""
    size = np.maximum(np.bincount(patch, minlength=count), 1)
    square = np.zeros(count)
    for axis in places.T:
        middle = np.bincount(patch, axis, count) / size
        square += np.bincount(patch, (axis - middle[patch]) ** 2, count) / size
    return np.asarray(np.sqrt(square))


def _in_unit_box(points: FloatArray, faces: IntArray) -> tuple[FloatArray, float]:
    """Return the points (p, 3) over the diagonal of the box around the faces, so that no unit overflows; and it."""
    if not len(faces):
        return points, 1.0
    used = points[used_points(faces, len(points))]
    size = np.ptp(used, axis=0)
    diagonal = float(size.max() * np.linalg.norm(size / max(float(size.max()), np.finfo(float).tiny)))
    if diagonal == 0.0:
        return points, 1.0
    return (points - used.min(axis=0)) / diagonal, diagonal


def _square_off(places: FloatArray, patch: IntArray, count: int) -> FloatArray:
    """Return (count,): the sum of the squared distances of places (n, 3) from the best plane of each patch (n,)."""
    return np.asarray(np.maximum(np.linalg.eigvalsh(spreads(places, patch, count)[1])[:, 0], 0.0))


def spreads(places: FloatArray, patch: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return places (n, 3) from the middle of their patch (n,), and the sums of their products (count, 3, 3).

    The eigenvector of the least eigenvalue of those sums is the normal of a patch's best plane.
    """
    size = np.maximum(np.bincount(patch, minlength=count), 1)
    middle = np.stack([np.bincount(patch, places[:, i], count) / size for i in range(3)], axis=1)
    away = places - middle[patch]
    spread = np.empty((count, 3, 3))
    for i in range(3):
        for j in range(3):
            spread[:, i, j] = np.bincount(patch, away[:, i] * away[:, j], count)
    return away, spread

"""Sample points that stand for the surface in integrals against smooth windows.

Where triangles are small against the window a point takes a third of the area of the faces around it; larger
triangles are split. Both are second-order quadratures, so refining a mesh hardly changes what is measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.areas import area_vectors
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Sampler", "Samples", "gathered", "plan_samples"]

# A face is split into so many rows, and all faces into about so many samples, at most: huge or very spiky surfaces
# cannot exhaust memory; the window then sees a coarser sum.
MAX_SPLIT = 64
MAX_SAMPLES = 1_500_000
# Cubes of a model that is so far spread out have no numbers.
MOST_CUBES = 2.0**60


@dataclass(frozen=True, eq=False)
class Samples:
    """Positions (q, 3), area vectors (q, 3) and areas (q,) of the samples of one set of point positions."""

    positions: FloatArray
    vectors: FloatArray
    areas: FloatArray


@dataclass(frozen=True, eq=False)
class Sampler:
    """Which samples a mesh gets; fixed once, so that moving points moves samples smoothly.

    faces: (m, 3); coarse: (c,) faces that are split; split_face (q',), split_weights (q', 3) barycentric,
    split_share (q',) share of the face's area. The first samples are the points, the others the splits.
    """

    faces: IntArray
    count: int
    fine: IntArray
    split_face: IntArray
    split_weights: FloatArray
    split_share: FloatArray

    def __call__(self, points: FloatArray) -> Samples:
        """Return the samples for positions (p, 3)."""
        vectors = area_vectors(points, self.faces)
        areas = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
        lumped = self._lump @ np.column_stack([vectors, areas])
        if not len(self.split_face):
            return Samples(points, lumped[:, :3], lumped[:, 3])
        corners = self.faces[self.split_face]
        middle = sum(self.split_weights[:, i, None] * points[corners[:, i]] for i in range(3))
        share = self.split_share[:, None]
        return Samples(
            np.concatenate([points, middle]),
            np.concatenate([lumped[:, :3], vectors[self.split_face] * share]),
            np.concatenate([lumped[:, 3], areas[self.split_face] * share[:, 0]]),
        )

    @cached_property
    def _lump(self) -> sp.csc_array:
        """(p, m): a third of each fine face to each of its points; the faces are its columns as they stand."""
        lengths = np.zeros(len(self.faces) + 1, np.int64)
        lengths[self.fine + 1] = 3
        corners = self.faces[self.fine].ravel()
        return sp.csc_array(
            (np.full(len(corners), 1.0 / 3.0), corners, np.cumsum(lengths)),
            shape=(self.count, len(self.faces)),
        )

    def normal_motion(self, samples: Samples, normals: FloatArray) -> sp.csr_array:
        """Return (q, p): flux through each sample per unit of displacement of each point along its normal."""
        lumped = np.einsum("ij,ij->i", normals, samples.vectors[: self.count])
        if not len(self.split_face):
            return sp.csr_array(sp.diags_array(lumped))
        rows = self.count + np.repeat(np.arange(len(self.split_face)), 3)
        columns = self.faces[self.split_face].ravel()
        along = np.einsum("qij,qj->qi", normals[self.faces[self.split_face]], samples.vectors[self.count :])
        values = (along * self.split_weights).ravel()
        index = np.arange(self.count)
        return sp.csr_array(
            (
                np.concatenate([lumped, values]),
                (np.concatenate([index, rows]), np.concatenate([index, columns])),
            ),
            shape=(self.count + len(self.split_face), self.count),
        )


def gathered(samples: Samples, size: float) -> Samples:
    """Return fewer samples: one for each cube of edge `size` and direction of facing, at the mean place.

    The six directions (the largest part of the area vector, and its sign) keep the sheets of a thin wall apart.
    """
    cube = np.floor(samples.positions / size).astype(np.int64)
    cube -= cube.min(axis=0) if len(cube) else 0
    facing = np.abs(samples.vectors).argmax(axis=1)
    backwards = np.take_along_axis(samples.vectors, facing[:, None], axis=1)[:, 0] < 0.0
    across = cube.max(axis=0) + 1 if len(cube) else np.ones(3, np.int64)
    places = 6.0 * float(np.prod(across.astype(np.float64)))
    if places > MOST_CUBES:
        return samples
    name = ((cube[:, 0] * across[1] + cube[:, 1]) * across[2] + cube[:, 2]) * 6 + 2 * facing + backwards
    group = _numbered(name, int(places))
    areas = np.bincount(group, samples.areas).astype(np.float64)
    shares = samples.areas / np.where(areas > 0.0, areas, 1.0)[group]
    return Samples(
        np.stack([np.bincount(group, shares * axis) for axis in samples.positions.T], axis=1),
        np.stack([np.bincount(group, axis) for axis in samples.vectors.T], axis=1),
        areas,
    )


def _numbered(names: IntArray, count: int) -> IntArray:
    """Return (n,): names in [0, count) as numbers 0, 1, ... in their order; by a table where that is small."""
    if count > 16 * len(names) + 1024:
        return np.asarray(np.unique(names, return_inverse=True)[1])
    used = np.zeros(count, dtype=bool)
    used[names] = True
    return np.asarray((np.cumsum(used) - 1)[names])


def plan_samples(points: FloatArray, faces: IntArray, longest: float) -> Sampler:
    """Choose samples so that, up to a limit on their number, no piece is longer than `longest`."""
    edge = np.sqrt(_longest_squares(points, faces))
    pieces = np.clip(np.ceil(edge / longest), 1, MAX_SPLIT).astype(np.int64)
    excess = float((pieces[pieces > 1] ** 2).sum()) / MAX_SAMPLES
    if excess > 1.0:
        pieces = np.clip(np.ceil(edge / (longest * np.sqrt(excess))), 1, MAX_SPLIT).astype(np.int64)
    owners, weights, shares = [], [], []
    for count in np.unique(pieces[pieces > 1]):
        split = np.flatnonzero(pieces == count)
        pattern = _centroids(int(count))
        owners.append(np.repeat(split, len(pattern)))
        weights.append(np.tile(pattern, (len(split), 1)))
        shares.append(np.full(len(owners[-1]), 1.0 / count**2))
    empty = np.zeros(0, np.int64)
    return Sampler(
        faces,
        len(points),
        np.flatnonzero(pieces == 1),
        np.concatenate(owners) if owners else empty,
        np.concatenate(weights) if weights else np.zeros((0, 3)),
        np.concatenate(shares) if shares else np.zeros(0),
    )


def _longest_squares(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m,): the squared length of each face's longest edge."""
    corners = np.ascontiguousarray(faces.T)
    squares = np.zeros((3, len(faces)))
    for axis in np.ascontiguousarray(points.T):
        ends = axis.take(corners)
        squares += (ends - np.roll(ends, 1, axis=0)) ** 2
    return np.asarray(squares.max(axis=0))


@lru_cache(maxsize=MAX_SPLIT)
def _centroids(count: int) -> FloatArray:
    """Barycentric centroids (count^2, 3) of a triangle cut into count^2 equal ones."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    up = np.column_stack([i[i + j < count], j[i + j < count]]) + 1.0 / 3.0
    down = np.column_stack([i[i + j < count - 1], j[i + j < count - 1]]) + 2.0 / 3.0
    first = np.concatenate([up, down]) / count
    return np.column_stack([first, 1.0 - first.sum(axis=1)])

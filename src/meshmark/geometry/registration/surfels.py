"""A surface as small oriented pieces of nearly equal size, whatever its triangles are and however noisy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from meshmark.geometry.adjacency import mean_squared_edge, unique_edges
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.scale_space import discrete_gaussian, random_walk
from meshmark.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


__all__ = ["Surfels", "low_passed", "make_surfels"]

# Normals fall into this many groups (their largest coordinate and its sign): two sheets never share a piece.
SIDES = 6
# The series of the discrete Gaussian is cut here: far below what noise leaves.
TOLERANCE = 1e-4


@dataclass(frozen=True, eq=False, kw_only=True)
class Surfels:
    """n pieces of surface: places (n, 3), unit normals (n, 3), areas (n,)."""

    places: FloatArray
    normals: FloatArray
    areas: FloatArray

    @cached_property
    def tree(self) -> cKDTree:
        """The places, prepared for searches."""
        return kd_tree(self.places)

    def __len__(self) -> int:
        return len(self.areas)

    def take(self, rows: IntArray) -> Surfels:
        """Return some of the pieces."""
        return Surfels(places=self.places[rows], normals=self.normals[rows], areas=self.areas[rows])


def low_passed(points: FloatArray, faces: IntArray, sigma: float) -> FloatArray:
    """Return (p, 3): the points smoothed along the surface by the discrete Gaussian of width `sigma`."""
    edges = unique_edges(faces)
    squared = mean_squared_edge(points, edges)
    if not squared > 0.0:
        return points
    walk = random_walk(points, edges)
    return np.asarray(discrete_gaussian(walk, points, 2.0 * sigma**2 / squared, TOLERANCE)[0])


def make_surfels(points: FloatArray, faces: IntArray, size: float) -> Surfels:
    """Return one piece for each cube of side `size` and each side of the surface in it.

    A piece is the area-weighted mean of what lies there; faces without area give none.
    """
    samples = plan_samples(points, faces, size)(points)
    solid = samples.areas > 0.0
    places, vectors, areas = samples.positions[solid], samples.vectors[solid], samples.areas[solid]
    group = _groups(places, vectors, size)
    count = int(group.max()) + 1 if len(group) else 0
    total = np.bincount(group, areas, count)
    middle = _sums(group, places * areas[:, None], count) / total[:, None]
    normal = _sums(group, vectors, count)
    length = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    kept = length > 1e-3 * total  # where a piece is folded onto itself it has no side
    return Surfels(places=middle[kept], normals=normal[kept] / length[kept, None], areas=length[kept])


def _groups(places: FloatArray, vectors: FloatArray, size: float) -> IntArray:
    """Return (q,): the number of the cube and side of each sample."""
    cube = np.floor(places / size).astype(np.int64)
    cube -= cube.min(axis=0, initial=0)
    largest = np.argmax(np.abs(vectors), axis=1)
    side = 2 * largest + (np.take_along_axis(vectors, largest[:, None], axis=1)[:, 0] < 0.0)
    wide = cube.max(axis=0, initial=0) + 1
    key = ((cube[:, 0] * wide[1] + cube[:, 1]) * wide[2] + cube[:, 2]) * SIDES + side
    return np.asarray(np.unique(key, return_inverse=True)[1], np.int64)


def _sums(group: IntArray, values: FloatArray, count: int) -> FloatArray:
    return np.stack([np.bincount(group, column, count) for column in values.T], axis=1)

"""Vertices that coincide in the file are one point to everything that computes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["Welded", "weld"]


@dataclass(frozen=True, eq=False)
class Welded:
    """A mesh whose exactly coincident vertices are one point.

    points:          (p, 3) float64, pairwise different, in the order of their first vertex.
    faces:           (m', 3) int64 in point indices; faces without three different points are left out.
    point_of_vertex: (n,) int64, `points[point_of_vertex]` are the vertices (with -0.0 read as 0.0).
    """

    points: FloatArray
    faces: IntArray
    point_of_vertex: IntArray

    @property
    def vertex_of_point(self) -> IntArray:
        """(p,) int64: the first vertex of each point."""
        first = np.empty(len(self.points), np.int64)
        backwards = self.point_of_vertex[::-1]
        first[backwards] = np.arange(len(backwards))[::-1]  # the last assignment stays
        return first


def weld(mesh: Mesh) -> Welded:
    """Join the vertices of `mesh` that coincide exactly; texture seams and STL corners close up.

    Vertices that no face uses stay as points of their own.
    """
    vertices = mesh.vertices + 0.0  # -0.0 + 0.0 is 0.0: equal numbers get equal bits
    order = _order_equal_together(vertices)
    starts = _group_starts(vertices, order)
    first = np.minimum.reduceat(order, starts) if len(order) else order
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    point_of_vertex = np.empty(len(vertices), np.int64)
    point_of_vertex[order] = np.repeat(rank, np.diff(starts, append=len(order)))
    a, b, c = (corners := point_of_vertex[mesh.faces]).T
    faces = corners[(a != b) & (b != c) & (c != a)]
    return Welded(vertices[np.sort(first)], faces, point_of_vertex)


def _order_equal_together(vertices: FloatArray) -> IntArray:
    """Return a permutation that puts equal rows next to each other."""
    keys = _hash_rows(vertices)
    order = np.argsort(keys)
    same_key = np.diff(keys[order]) == 0
    if (same_key & ~_equals_previous(vertices, order)).any():  # two different rows share a hash
        order = np.lexsort(vertices.T)
    return order


def _hash_rows(vertices: FloatArray) -> NDArray[np.uint64]:
    x, y, z = vertices.view(np.uint64).T
    key: NDArray[np.uint64] = x * np.uint64(0x9E3779B97F4A7C15)
    key ^= key >> np.uint64(29)
    key = (key + y) * np.uint64(0xBF58476D1CE4E5B9)
    key ^= key >> np.uint64(32)
    key = (key + z) * np.uint64(0x94D049BB133111EB)
    key ^= key >> np.uint64(31)
    return key


def _equals_previous(vertices: FloatArray, order: IntArray) -> NDArray[np.bool_]:
    rows = vertices[order]
    same: NDArray[np.bool_] = (rows[1:] == rows[:-1]).all(axis=1)
    return same


def _group_starts(vertices: FloatArray, order: IntArray) -> IntArray:
    return np.flatnonzero(np.concatenate([[True], ~_equals_previous(vertices, order)])[: len(order)])

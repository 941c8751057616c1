"""Vertices that coincide in the file are one point to everything that computes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["any_coincide", "weld"]


def weld(mesh: Mesh) -> Surface:
    """Join the vertices of a mesh that coincide exactly; texture seams and STL corners close up.

    `surface_of` does this once for each mesh and remembers the answer.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    Surface
        Vertices that no face uses are points of their own.
    """
    vertices = mesh.vertices + 0.0  # -0.0 + 0.0 is 0.0: equal numbers get equal bits
    order = _order_equal_together(vertices)
    starts = _group_starts(vertices, order)
    first = np.minimum.reduceat(order, starts) if len(order) else order
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    point_of_vertex = np.empty(len(vertices), np.int64)
    point_of_vertex[order] = np.repeat(rank, np.diff(starts, append=len(order)))
    apart = len(first) == len(vertices)
    corners = mesh.faces if apart else point_of_vertex[mesh.faces]
    a, b, c = corners.T
    proper = (a != b) & (b != c) & (c != a)
    return Surface(
        points=vertices if apart else vertices[np.sort(first)],
        faces=corners if proper.all() else corners[proper],  # those of the mesh, where all are as they were
        point_of_vertex=point_of_vertex,
    )


def any_coincide(points: FloatArray) -> bool:
    """Return whether two of the points may coincide; False is certain, True is wrong about once in 2^64 pairs.

    Parameters
    ----------
    points : (p, 3) float array
        Without negative zeros.
    """
    keys = np.sort(_hash_rows(points))
    return bool((keys[1:] == keys[:-1]).any())


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

"""Points that were moved return to the miniature's surface, and blend into what stayed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.mesh import FloatArray, IntArray

__all__ = ["draw_back"]

# Lengths of detail, in edges of the miniature: coarser, the miniature says where points lie; finer, they keep the
# shape that they have among themselves. From stiff to soft, each for so many rounds.
DETAILS, ROUNDS = (4.0, 2.0, 1.2), 6


def draw_back(
    points: FloatArray, faces: IntArray, free: NDArray[np.bool_], mini: tuple[FloatArray, IntArray]
) -> FloatArray:
    """Return the points (p, 3), those that are `free` (p,) drawn to the miniature, all others where they are.

    mini: points and faces in the same coordinates. Near the points that stay, the miniature is corrected by how far
    it lies off them.
    """
    used = np.zeros(len(points), bool)
    used[faces] = True
    free = free & used
    if not free.any():
        return points.copy()
    graph = adjacency(unique_edges(faces), len(points))
    index = SurfaceIndex(*mini)
    edges = unique_edges(mini[1])
    length = float(np.sqrt(((mini[0][edges[:, 0]] - mini[0][edges[:, 1]]) ** 2).sum(axis=1).mean()))
    degree = np.maximum(np.asarray(graph.sum(axis=1)).ravel(), 1.0)
    walk = csc_array(diags_array(np.ones(len(points))) - diags_array(1.0 / degree) @ graph)
    near = np.asarray(graph[free].sum(axis=0)).ravel() > 0.0
    rim = near & ~free & used
    step = _mean_edge(points, faces, free)
    offset = _carried(walk, points, free, rim, index)
    moved = points.copy()
    rows = np.flatnonzero(free)
    bilaplacian = (walk.T @ walk).tocsc()
    inner = bilaplacian[rows][:, rows]
    for detail in DETAILS:
        stiffness = (detail * length / (2.0 * np.pi * step)) ** 4 * 16.0
        solver = splu(csc_array(stiffness * inner + diags_array(np.ones(len(rows)))))
        for _ in range(ROUNDS):
            target = index.nearest(moved[rows] - offset[rows]).points + offset[rows]
            moved[rows] += solver.solve(target - moved[rows])
    return moved


def _mean_edge(points: FloatArray, faces: IntArray, free: NDArray[np.bool_]) -> float:
    edges = unique_edges(faces[free[faces].any(axis=1)])
    return float(np.sqrt(((points[edges[:, 0]] - points[edges[:, 1]]) ** 2).sum(axis=1).mean()))


def _carried(
    walk: csc_array,
    points: FloatArray,
    free: NDArray[np.bool_],
    rim: NDArray[np.bool_],
    index: SurfaceIndex,
) -> FloatArray:
    """Return (p, 3): how far the rim lies off the miniature, carried on into the free points harmonically."""
    offset = np.zeros(points.shape)
    if not rim.any():
        return offset
    offset[rim] = points[rim] - index.nearest(points[rim]).points
    rows = np.flatnonzero(free)
    part = walk[rows]
    held = csc_array(part[:, rows] + 1e-6 * diags_array(np.ones(len(rows))))
    offset[rows] = splu(held).solve(-(part[:, np.flatnonzero(rim)] @ offset[rim]))
    return offset

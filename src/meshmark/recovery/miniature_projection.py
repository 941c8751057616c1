"""Points that were moved return to the miniature's surface, and blend into what stayed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, diags_array

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU

__all__ = ["MiniatureProjection", "spreads"]

# Lengths of detail, in edges of the miniature: coarser, the miniature says where points lie; finer, they keep the
# shape that they have among themselves. From stiff to soft, each for some rounds, fewer where points are many.
DETAILS = (16.0, 8.0, 4.0, 2.0, 1.2)
MOST_ROUNDS, LEAST_ROUNDS, QUERIES = 12, 3, 100_000
# In the end the surface is smooth up to this length, as faces of the miniature are not.
SMOOTH, SMOOTH_ROUNDS = 0.9, 4


class MiniatureProjection:
    """A surface whose altered points can be projected onto the miniature.

    points: (p, 3); faces: (m, 3); graph: (p, p) adjacency; altered: (p,), points of faces only; mini: points and
    faces in the same coordinates. Near points that stay, the miniature is corrected by how far it lies off them.
    """

    def __init__(
        self,
        points: FloatArray,
        faces: IntArray,
        graph: csr_array,
        altered: NDArray[np.bool_],
        mini: tuple[FloatArray, IntArray],
    ) -> None:
        self.points, self.faces, self.altered = points, faces, altered
        self.index = SurfaceIndex(*mini)
        edges = unique_edges(mini[1])
        self.detail = _length(mini[0], edges)
        degree = np.maximum(np.asarray(graph.sum(axis=1)).ravel(), 1.0)
        self.walk = csr_array(diags_array(np.ones(len(points))) - diags_array(1.0 / degree) @ graph)
        boundary = (np.asarray(graph @ altered.astype(float)) > 0.0) & ~altered
        self.offset = self._carried(boundary)

    def _carried(self, boundary: NDArray[np.bool_]) -> FloatArray:
        """Return (p, 3): distance of the boundary from the miniature, extended harmonically into altered points."""
        offset = np.zeros(self.points.shape)
        held, rows = np.flatnonzero(boundary), np.flatnonzero(self.altered)
        if len(held) and len(rows):
            offset[held] = self.points[held] - self.index.nearest(self.points[held]).points
            from scipy.sparse.linalg import splu

            part = self.walk[rows]
            matrix = csc_array(part[:, rows] + 1e-6 * diags_array(np.ones(len(rows))))
            offset[rows] = splu(matrix).solve(-(part[:, held] @ offset[held]))
        return offset

    def distances(self) -> FloatArray:
        """Return how far each altered point lies off the corrected miniature."""
        places = (self.points - self.offset)[self.altered]
        return self.index.nearest(places).distances if len(places) else np.zeros(0)

    def project(self, moving: NDArray[np.bool_]) -> FloatArray:
        """Return the points, the altered ones that are `moving` (p,) projected onto the corrected miniature."""
        moved = self.points.copy()
        rows = np.flatnonzero(moving)
        if not len(rows):
            return moved
        step = _length(self.points, unique_edges(self.faces[moving[self.faces].any(axis=1)]))
        columns = self.walk[:, rows]
        inner = csc_array(columns.T @ columns)
        rounds = int(np.clip(QUERIES // len(rows), LEAST_ROUNDS, MOST_ROUNDS))
        for detail in DETAILS:
            _, solver = self._held(inner, detail, step)
            for _ in range(rounds):
                moved[rows] += solver.solve(self._targets(moved, rows) - moved[rows])
        return self.smoothed(moving, moved)

    def smoothed(self, moving: NDArray[np.bool_], moved: FloatArray) -> FloatArray:
        """Return the points `moved` (p, 3), those that are `moving` smooth below the length of detail."""
        moved = moved.copy()
        rows = np.flatnonzero(moving)
        step = _length(moved, unique_edges(self.faces[moving[self.faces].any(axis=1)]))
        columns = self.walk[:, rows]
        stiffness, solver = self._held(csc_array(columns.T @ columns), SMOOTH, step)
        wanted = self._layout(moved, rows, columns)
        for _ in range(SMOOTH_ROUNDS):
            moved[rows] = solver.solve(stiffness * wanted + self._targets(moved, rows))
        return moved

    def _held(self, inner: csc_array, detail: float, step: float) -> tuple[float, SuperLU]:
        """Return the stiffness that keeps shapes below a length of detail, and the solver with it."""
        from scipy.sparse.linalg import splu

        stiffness = 16.0 * (detail * self.detail / (2.0 * np.pi * step)) ** 4
        return stiffness, splu(csc_array(stiffness * inner + diags_array(np.ones(inner.shape[0]))))

    def _targets(self, moved: FloatArray, rows: IntArray) -> FloatArray:
        places = moved[rows] - self.offset[rows]
        return np.asarray(self.index.nearest(places).points + self.offset[rows])

    def _layout(self, moved: FloatArray, rows: IntArray, columns: csr_array) -> FloatArray:
        """Return the right side, (k, 3), for points that keep their places among neighbours along the surface only.

        Out of the surface they are to lie as smoothly as their surroundings allow.
        """
        normals = vertex_normals(moved, self.faces)
        off = self.walk @ moved
        along = off - np.einsum("ij,ij->i", off, normals)[:, None] * normals
        along[np.setdiff1d(np.arange(len(moved)), rows)] = 0.0
        fixed = moved.copy()
        fixed[rows] = 0.0
        return np.asarray(columns.T @ (along - self.walk @ fixed))


def spreads(part: IntArray, squares: FloatArray, count: int) -> FloatArray:
    """Return (count,): the root of the mean of the `squares` (k,) of each part (k,), 0 where it has none."""
    size = np.maximum(np.bincount(part, minlength=count), 1)
    return np.asarray(np.sqrt(np.bincount(part, squares, count) / size))


def _length(points: FloatArray, edges: IntArray) -> float:
    return float(np.sqrt(((points[edges[:, 0]] - points[edges[:, 1]]) ** 2).sum(axis=1).mean()))

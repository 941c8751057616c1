"""A mesh as the rivals see it: the different points that faces use, and the way back to the vertices."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from meshmark.errors import CapacityError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.vertex_displacement import diagonal_of, displacement_rms

__all__ = ["Host"]


class Host:
    """The points (p, 3) of a mesh that its faces (m, 3) use, coincident vertices being one point.

    Raises `CapacityError` for a mesh without faces.
    """

    def __init__(self, mesh: Mesh) -> None:
        welded = weld(mesh)
        used = np.zeros(len(welded.points), bool)
        used[welded.faces.ravel()] = True
        if not used.any():
            raise CapacityError("the model has no faces, expected a surface to mark")
        number = np.cumsum(used) - 1
        self.mesh = mesh
        self.points: FloatArray = welded.points[used]
        self.faces: IntArray = number[welded.faces]
        self._point = np.where(used, number, -1)[welded.point_of_vertex]

    def moved(self, points: FloatArray) -> Mesh:
        """Return the mesh with its points at other places, (p, 3); vertices that no face uses stay."""
        at = self._point[:, None]
        return self.mesh.with_vertices(np.where(at < 0, self.mesh.vertices, points[self._point]))

    def with_points(self, points: FloatArray) -> Host:
        """Return the same with its points at other places, (p, 3), also where two of them meet."""
        other = copy(self)
        other.points = points
        return other

    def rms(self, points: FloatArray) -> float:
        """Return the RMS vertex displacement over the diagonal when the points lie at these places."""
        return displacement_rms(self.mesh, self.moved(points)) / self.diagonal

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box."""
        return diagonal_of(self.mesh)

    @cached_property
    def edges(self) -> IntArray:
        """(e, 2): each edge once."""
        return unique_edges(self.faces)

    @cached_property
    def graph(self) -> csr_array:
        """(p, p): 1 where two points share an edge."""
        return adjacency(self.edges, len(self.points))

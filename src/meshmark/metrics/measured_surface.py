"""A model's surface made ready for measuring once, however many measures look at it."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.closest_point import Nearest, SurfaceIndex
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["MeasuredSurface", "surface_of"]


class MeasuredSurface:
    """The welded points (p, 3) and faces of a model, and its closest-point index.

    faces: (m, 3) those with three different points; all_faces: with those that collapse;
    point_of_vertex: (n,) as in `Surface`; low, longest: corner and longest side of the bounding box.
    """

    def __init__(self, mesh: Mesh) -> None:
        welded = weld(mesh)
        if not len(welded.faces):
            raise InputError(
                "the model has no triangle with three different corners, expected a surface to measure"
            )
        if not np.ptp(welded.points, axis=0).any():
            raise InputError("all vertices of the model are in one place, expected a model with an extent")
        self.points, self.faces, self.point_of_vertex = welded.points, welded.faces, welded.point_of_vertex
        self.low = self.points.min(axis=0)
        self.longest = float(np.ptp(self.points, axis=0).max())
        self._corners = mesh.faces
        self._nearest: WeakKeyDictionary[MeasuredSurface, Nearest] = WeakKeyDictionary()

    @property
    def all_faces(self) -> IntArray:
        """(m', 3) the faces in point indices, with those that have fewer than three different points."""
        return self.point_of_vertex[self._corners]

    @cached_property
    def index(self) -> SurfaceIndex:
        """The surface prepared for closest-point queries."""
        return SurfaceIndex(self.points, self.faces)

    def scaled(self, points: FloatArray) -> FloatArray:
        """Return positions (n, 3) in the unit box of this surface, where squares and areas stay in range."""
        out: FloatArray = (points - self.low) / self.longest
        return out

    @cached_property
    def areas_and_normals(self) -> tuple[FloatArray, FloatArray]:
        """(p,) a third of the area of the faces at each point, in squared longest sides; (p, 3) unit normals, the
        area-weighted means of those faces, zeros where they cancel.
        """
        return vertex_areas_and_normals(self.scaled(self.points), self.faces)

    def equals(self, other: MeasuredSurface) -> bool:
        """Whether both have the same points and faces in the same order."""
        return np.array_equal(self.points, other.points) and np.array_equal(self.faces, other.faces)

    def nearest_on(self, other: MeasuredSurface) -> Nearest:
        """Return the closest point of the other surface to each of these points."""
        if other not in self._nearest:
            self._nearest[other] = other.index.nearest(self.points)
        return self._nearest[other]


_SURFACES: WeakKeyDictionary[Mesh, MeasuredSurface] = WeakKeyDictionary()


def surface_of(mesh: Mesh) -> MeasuredSurface:
    """Return the surface of a model, made once while the model lives; raises `InputError` where there is none."""
    if mesh not in _SURFACES:
        _SURFACES[mesh] = MeasuredSurface(mesh)
    return _SURFACES[mesh]

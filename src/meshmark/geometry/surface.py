"""A surface: points joined by faces, and what is computed of them, each once and when it is first asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.geometry.areas import face_areas, face_lengths, vertex_areas
from meshmark.geometry.connectivity import Connectivity
from meshmark.geometry.extent import diagonal
from meshmark.geometry.frame import MIRROR, Frame, canonical_frame
from meshmark.geometry.invariants import shape_invariants
from meshmark.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from meshmark.geometry.visibility import VisibleChange

__all__ = ["Surface"]

# What a surface and its mirror image have in common.
SAME_MIRRORED = frozenset({"face_areas", "face_lengths", "point_areas", "point_shares", "diagonal"})


@dataclass(frozen=True, eq=False, kw_only=True)
class Surface:
    """A mesh whose exactly coincident vertices are one point (see `weld`).

    points:          (p, 3) float64, pairwise different, in the order of their first vertex.
    faces:           (m', 3) int64 in point indices; faces without three different points are left out.
    point_of_vertex: (n,) int64, `points[point_of_vertex]` are the vertices (with -0.0 read as 0.0).

    The arrays are never changed in place. All lengths are in scene units.
    """

    points: FloatArray
    faces: IntArray
    point_of_vertex: IntArray

    @cached_property
    def connectivity(self) -> Connectivity:
        """How the points are joined; surfaces that differ in their positions alone share it (`moved`)."""
        return Connectivity(count=len(self.points), faces=self.faces)

    @cached_property
    def vertex_of_point(self) -> IntArray:
        """(p,) int64: the first vertex of each point."""
        first = np.empty(len(self.points), np.int64)
        backwards = self.point_of_vertex[::-1]
        first[backwards] = np.arange(len(backwards))[::-1]  # the last assignment stays
        return first

    @cached_property
    def visible_change(self) -> VisibleChange:
        """What judges how visible displacements of the points are."""
        from meshmark.geometry.visibility import VisibleChange  # for embeddings alone

        return VisibleChange(self.points, self.faces)

    @property
    def used(self) -> NDArray[np.bool_]:
        """(p,) which points faces use."""
        return self.connectivity.used

    @property
    def edges(self) -> IntArray:
        """(e, 2) each undirected edge once, smaller index first, sorted."""
        return self.connectivity.edges

    @property
    def graph(self) -> csr_array:
        """(p, p) symmetric sparse matrix with 1 at both places of each edge."""
        return self.connectivity.graph

    @property
    def walk(self) -> csr_array:
        """(p, p) the chances of a step from each point to each of its neighbours, all alike."""
        return self.connectivity.walk

    @cached_property
    def face_areas(self) -> FloatArray:
        """(m',) area of each face."""
        return face_areas(self.points, self.faces)

    @cached_property
    def face_lengths(self) -> FloatArray:
        """(m',) the longest edge of each face."""
        return face_lengths(self.points, self.faces)

    @cached_property
    def mean_face_length(self) -> float:
        """The longest edge of a face, mean over the area; 0 without area."""
        return float(self.face_lengths @ self.face_areas) / max(
            float(self.face_areas.sum()), np.finfo(float).tiny
        )

    @cached_property
    def point_areas(self) -> FloatArray:
        """(p,) a third of the area of the faces at each point."""
        return vertex_areas(self.points, self.faces)

    @cached_property
    def point_shares(self) -> FloatArray:
        """(p,) `point_areas` over the area of the whole; in any unit, even where areas are beyond floats."""
        if not len(self.faces):
            return np.zeros(len(self.points))
        tiny = np.finfo(float).tiny
        areas = vertex_areas(self.points / max(self.diagonal, tiny), self.faces)
        return np.asarray(areas / max(float(areas.sum()), tiny))

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box of the points that faces use."""
        return diagonal(self.points, self.faces)

    @cached_property
    def frame(self) -> Frame:
        """The canonical frame; raises `InputError` where there is no surface."""
        return canonical_frame(self.points, self.faces)

    @cached_property
    def invariants(self) -> FloatArray:
        """The numbers that `shape_invariants` returns; raises `InputError` where there is no surface."""
        return shape_invariants(self.points, self.faces, self.frame, self.face_lengths)

    def mirrored(self) -> Surface:
        """Return the mirror image; what a reflection leaves as it is, or turns into its image, is computed once."""
        result = replace(self, points=self.points * MIRROR, faces=self.faces[:, ::-1])
        kept = {name: self.__dict__[name] for name in SAME_MIRRORED & self.__dict__.keys()}
        result.__dict__.update(
            kept,
            frame=self.frame.mirrored(),
            invariants=self.invariants,
            connectivity=self.connectivity.turned_over(),
        )
        return result

    def moved(self, points: FloatArray) -> Surface:
        """Return the surface with its points elsewhere; faces and connectivity are shared.

        Parameters
        ----------
        points : (p, 3) float array
            New positions, which the caller knows to be pairwise different.

        Returns
        -------
        Surface
            A plain one, whatever this one is.
        """
        result = Surface(points=points, faces=self.faces, point_of_vertex=self.point_of_vertex)
        result.__dict__["connectivity"] = self.connectivity
        return result

"""The surface of an interactive view: what a file shows with fewer triangles, and which vertex each point was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.attacks.simplification import decimated
from meshmark.errors import InputError
from meshmark.geometry.view import Stance, level_view
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["LARGEST", "ViewSurface", "view_surface"]

LARGEST = 100_000
"""Triangles that a view has at most: a page of 3 MB, which a telephone turns without jerks."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ViewSurface:
    """points: (p, 3), x to the right, y up, z towards who stands in front; faces: (m, 3).

    vertex: (p,) the vertex of the file that each point takes its values from. shown_of: triangles of the file where
    the view has fewer, else None.
    """

    points: FloatArray
    faces: IntArray
    vertex: IntArray
    shown_of: int | None


def view_surface(mesh: Mesh, stance: Stance | None = None, *, most: int = LARGEST) -> ViewSurface:
    """Return the surface of a mesh upright, with at most about `most` triangles.

    stance: how the model stands, where its file says so. Raises `InputError` where there is no triangle with three
    different points.
    """
    welded = weld(mesh)
    if not len(welded.faces):
        raise InputError(
            f"the model has {len(mesh.faces)} faces, none with three different points, expected a surface"
        )
    used, corners = np.unique(welded.faces, return_inverse=True)
    points, faces, vertex = welded.points[used], corners.reshape(-1, 3), welded.vertex_of_point[used]
    shown_of = None
    if len(faces) > most:
        points, faces, kept = decimated(points, faces, most)
        vertex, shown_of = vertex[kept], len(welded.faces)
    turn = level_view(welded.points, stance)
    return ViewSurface(points=points @ turn.T, faces=faces, vertex=vertex, shown_of=shown_of)

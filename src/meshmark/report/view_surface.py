"""The surface that a page shows: a model upright, with fewer triangles where it has very many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.attacks.simplification import decimated
from meshmark.errors import InputError
from meshmark.geometry.view import Stance, level_view, three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.report.picture import Panel
from meshmark.scene.stance import stance_of

__all__ = ["LARGEST", "PICTURE_VIEW", "ViewSurface", "view_surface"]

LARGEST = 100_000
"""Triangles that a page shows at most: about 3 MB, which a telephone turns without jerks."""
PICTURE_VIEW = three_quarter_view(np.zeros((1, 3)), Stance(up=(0.0, 1.0, 0.0), front=(0.0, 0.0, 1.0)))
"""Rotation (3, 3) from which still pictures show an upright surface: that in which the viewer starts."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ViewSurface:
    """points: (p, 3), x to the right, y up, z towards who stands in front, of a size of about 1; faces: (m, 3).

    vertex: (p,) the vertex of the file that each point takes its values from. shown_of: triangles of the file where
    there are fewer here, else None.
    """

    points: FloatArray
    faces: IntArray
    vertex: IntArray
    shown_of: int | None

    def panel(self, colours: FloatArray | None = None) -> Panel:
        """Return the panel of a picture; colours: (n, 3) linear RGB of the file's vertices, None for clay."""
        shades = None if colours is None else colours[self.vertex]
        return Panel(caption="", points=self.points, faces=self.faces, colours=shades)


def view_surface(mesh: Mesh, *, turn: FloatArray | None = None, most: int = LARGEST) -> ViewSurface:
    """Return the surface of a mesh upright, with at most about `most` triangles.

    turn: rotation (3, 3) that sets it upright; by default as its file says, else as it stands most broadly. Raises
    `InputError` where there is no triangle with three different points.
    """
    welded = weld(mesh)
    if not len(welded.faces):
        given = f"{len(mesh.faces)} faces, none with three different points"
        raise InputError(f"the model has {given}, expected a surface")
    used, corners = np.unique(welded.faces, return_inverse=True)
    points, faces, vertex = welded.points[used], corners.reshape(-1, 3), welded.vertex_of_point[used]
    if turn is None:
        turn = level_view(welded.points, stance_of(mesh))
    points = points - points.min(axis=0)
    points /= (
        float(points.max()) or 1.0
    )  # single precision, in which a view is drawn, holds it whatever its unit
    shown_of = None
    if len(faces) > most:
        points, faces, kept = decimated(points, faces, most)
        vertex, shown_of = vertex[kept], len(welded.faces)
    return ViewSurface(points=points @ turn.T, faces=faces, vertex=vertex, shown_of=shown_of)

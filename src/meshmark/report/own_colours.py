"""A mesh in its own colours: those of its vertices, its materials, and the images of its textures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from meshmark.geometry.surface_of import surface_of
from meshmark.io.colors import to_linear
from meshmark.io.paint import Paint
from meshmark.io.paint_of import paint_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.painted import painted_vertices
from meshmark.report.picture import Panel
from meshmark.report.view_surface import ViewSurface

__all__ = ["OwnColours", "own_colours", "own_panel", "vertex_colours"]


@dataclass(frozen=True, eq=False, kw_only=True)
class OwnColours:
    """The colours of a mesh.

    vertices: (n, 3) linear RGB that its file has for each vertex, None without. paint: of its triangles, or None.
    """

    mesh: Mesh
    vertices: FloatArray | None
    paint: Paint | None

    def at_vertices(self) -> FloatArray | None:
        """Return (n, 3) linear RGB with the paint taken at the vertices; None for a mesh without colours."""
        if self.paint is None:
            return self.vertices
        found = painted_vertices(self.paint, self.mesh.faces, len(self.mesh.vertices))
        return found if self.vertices is None else found * self.vertices

    def on(self, shown: ViewSurface) -> Panel:
        """Return the panel of a page's surface; where that has fewer faces, the paint is taken at vertices."""
        paint = None if shown.shown_of is not None else self._welded_paint()
        if paint is None or len(paint.image) != len(shown.faces):
            return shown.panel(self.at_vertices())
        return replace(shown.panel(self.vertices), paint=paint)

    def _welded_paint(self) -> Paint | None:
        """Return the paint of the faces that are left when coincident vertices are joined."""
        if self.paint is None:
            return None
        a, b, c = surface_of(self.mesh).point_of_vertex[self.mesh.faces].T
        return self.paint.take(np.flatnonzero((a != b) & (b != c) & (c != a)))

    def panel(self, caption: str) -> Panel:
        """Return the panel of the mesh."""
        surface = surface_of(self.mesh)
        colours = None if self.vertices is None else self.vertices[surface.vertex_of_point]
        return Panel(
            caption=caption,
            points=surface.points,
            faces=surface.faces,
            colours=colours,
            paint=self._welded_paint(),
        )


def own_colours(mesh: Mesh) -> OwnColours:
    """Return the colours that the file of a mesh has for it."""
    return OwnColours(mesh=mesh, vertices=vertex_colours(mesh), paint=paint_of(mesh))


def own_panel(mesh: Mesh, caption: str) -> Panel:
    """Return the panel of a mesh in its own colours, clay without any."""
    return own_colours(mesh).panel(caption)


def vertex_colours(mesh: Mesh) -> FloatArray | None:
    """Return (n, 3) linear RGB where the file has one colour for each vertex, else None."""
    attributes = None if mesh.document is None else mesh.document.attributes()
    if attributes is None or attributes.colors is None or len(attributes.colors) != len(mesh.vertices):
        return None
    return to_linear(attributes.colors[:, :3] / 255.0)

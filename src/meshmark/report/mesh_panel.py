"""A mesh as a panel of a picture: its points welded, colours given for each vertex."""

from __future__ import annotations

from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.picture import Panel

__all__ = ["mesh_panel"]


def mesh_panel(mesh: Mesh, caption: str, colours: FloatArray | None = None) -> Panel:
    """Return the panel of a mesh; colours: (n, 3) linear RGB of its vertices, None for clay."""
    welded = weld(mesh)
    shades = None if colours is None else colours[welded.vertex_of_point]
    return Panel(caption=caption, points=welded.points, faces=welded.faces, colours=shades)

"""The picture of an embedding: original, marked, and how far the mark turns the normals that shading shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import degrees_between
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.colours import heat
from meshmark.report.own_colours import own_panel
from meshmark.report.picture import Panel, panels

__all__ = ["DARKEST", "shading_picture"]

DARKEST = 3.0
"""Change of a normal, degrees, that has the darkest colour; a quarter of it is just noticed where it is smooth."""


def shading_picture(
    original: Mesh, marked: Mesh, path: Path | str, *, size: int = 900, staging: Staging | None = None
) -> None:
    """Save a PNG of three panels: original, marked, and the change of each point's normal as colour.

    The meshes have the same vertices in the same order. staging: takes the file, to move it into place together
    with others. Raises `OutputError` where the file cannot be written.
    """
    surface = surface_of(original)
    after, faces = marked.vertices[surface.vertex_of_point], surface.faces
    own = own_panel(original, "original")
    turned = degrees_between(vertex_normals(after, faces), vertex_normals(surface.points, faces))
    shown = (
        own,
        replace(own, caption="marked", points=after),
        Panel(
            caption=f"change of shading (darkest: normals turned by {DARKEST:g} degrees)",
            points=after,
            faces=faces,
            colours=heat(turned / DARKEST),
        ),
    )
    panels(shown, path, size=size, staging=staging)

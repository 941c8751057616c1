"""The picture of an embedding: original, marked, and how far the mark turns the normals that shading shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from meshmark.geometry.areas import area_vectors, face_areas, sum_at_points
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import degrees_between
from meshmark.io.staging import Staging
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.report.colours import heat
from meshmark.report.own_colours import own_panel
from meshmark.report.picture import Panel, panels
from meshmark.report.shade import steady_normals

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
    turned = _turned(surface.points, after, faces)
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


def _turned(before: FloatArray, after: FloatArray, faces: IntArray) -> FloatArray:
    """Return how far the normal of each point (p,) turns, degrees; where its faces' cancel, the RMS of theirs."""
    normals = steady_normals(before, faces)
    turned = degrees_between(normals, steady_normals(after, faces))
    cancelled = ~normals.any(axis=1)
    areas = face_areas(before, faces)
    change = degrees_between(_unit(area_vectors(before, faces)), _unit(area_vectors(after, faces)))
    square, around = sum_at_points(np.column_stack([areas * change**2, areas]), faces, len(before))[
        cancelled
    ].T
    turned[cancelled] = np.sqrt(square / np.where(around > 0.0, around, 1.0))
    return turned


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0)[:, None])

"""The picture of a comparison: two models, and how far the second is from the first as colour."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.view import three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.io.staging import Staging
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.colours import heat
from meshmark.report.mesh_panel import mesh_panel
from meshmark.report.own_colours import own_panel
from meshmark.report.picture import Bar, panels
from meshmark.scene.stance import stance_of

__all__ = ["displacement_picture", "distances"]


def displacement_picture(
    first: Mesh, second: Mesh, path: Path | str, *, size: int = 900, staging: Staging | None = None
) -> None:
    """Save a PNG of three panels: both models, and the distances of the second, with a bar in % of the diagonal.

    The darkest colour is the largest distance, the diagonal that of the first model's box. staging: takes the file,
    to move it into place together with others. Raises `OutputError` where the file cannot be written, and
    `InputError` where a model has no surface.
    """
    away = distances(first, second)
    diagonal = float(np.linalg.norm(np.ptp(first.vertices, axis=0))) or 1.0
    largest = float(away.max(initial=0.0))
    shown = (
        own_panel(first, "A"),
        own_panel(second, "B"),
        mesh_panel(second, "how far B is from A", heat(away / (largest or 1.0))),
    )
    ticks = tuple((at, f"{100 * at * largest / diagonal:.2g}") for at in (0.0, 0.25, 0.5, 0.75, 1.0))
    view = three_quarter_view(weld(first).points, stance_of(first))
    bar = Bar(title="distance, % of the diagonal", ticks=ticks if largest else ((0.0, "0"),))
    panels(shown, path, size=size, view=view, bar=bar, staging=staging)


def distances(first: Mesh, second: Mesh) -> FloatArray:
    """Return (n,): how far each vertex of the second mesh is from the first.

    From the vertex of the same number where both have equally many and the same faces, else from the closest point
    of the surface.
    """
    if first.vertices.shape == second.vertices.shape and np.array_equal(first.faces, second.faces):
        return np.asarray(np.linalg.norm(second.vertices - first.vertices, axis=1))
    welded = weld(first)
    return SurfaceIndex(welded.points, welded.faces).nearest(second.vertices).distances

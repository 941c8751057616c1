"""The picture of `meshmark demo`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.report.colours import heat
from meshmark.report.own_colours import own_panel
from meshmark.report.picture import Panel, panels

__all__ = ["demo_picture"]


def demo_picture(
    original: Mesh,
    marked: Mesh,
    changed: Mesh,
    path: Path | str,
    more: Sequence[Panel] = (),
    *,
    size: int = 640,
) -> None:
    """Save a PNG: original, marked, how far each point moved as colour, the changed copy, and a row with `more`.

    The three meshes have the same vertices in the same order. Raises `OutputError` where the file cannot
    be written.
    """
    own = own_panel(original, "original")
    at, faces = surface_of(original).vertex_of_point, own.faces
    moved = np.linalg.norm(marked.vertices - original.vertices, axis=1)[at]
    largest = float(moved.max(initial=0.0)) or 1.0
    diagonal = float(np.linalg.norm(np.ptp(original.vertices, axis=0))) or 1.0
    shown = (
        own,
        replace(own, caption="marked", points=marked.vertices[at]),
        Panel(
            caption=f"what moved (darkest: {100 * largest / diagonal:.2g} % of the diagonal)",
            points=marked.vertices[at],
            faces=faces,
            colours=heat(moved / largest),
        ),
        replace(own, caption="turned, resized, moved, noised", points=changed.vertices[at]),
    )
    panels((*shown, *more), path, size=size, columns=len(shown))

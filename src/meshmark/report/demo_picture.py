"""The picture of `meshmark demo`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.colours import heat, to_linear
from meshmark.report.picture import Panel, panels

__all__ = ["demo_picture", "vertex_colours"]


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
    welded = weld(original)
    at, faces = welded.vertex_of_point, welded.faces
    colours = vertex_colours(original)
    shades = None if colours is None else colours[at]
    moved = np.linalg.norm(marked.vertices - original.vertices, axis=1)[at]
    largest = float(moved.max(initial=0.0)) or 1.0
    diagonal = float(np.linalg.norm(np.ptp(original.vertices, axis=0))) or 1.0
    shown = (
        Panel(caption="original", points=original.vertices[at], faces=faces, colours=shades),
        Panel(caption="marked", points=marked.vertices[at], faces=faces, colours=shades),
        Panel(
            caption=f"what moved (darkest: {100 * largest / diagonal:.2g} % of the diagonal)",
            points=marked.vertices[at],
            faces=faces,
            colours=heat(moved / largest),
        ),
        Panel(
            caption="turned, resized, moved, noised", points=changed.vertices[at], faces=faces, colours=shades
        ),
    )
    panels((*shown, *more), path, size=size, columns=len(shown))


def vertex_colours(mesh: Mesh) -> FloatArray | None:
    """Return (n, 3) linear RGB where the file has one colour for each vertex, else None."""
    attributes = None if mesh.document is None else mesh.document.attributes()
    if attributes is None or attributes.colors is None or len(attributes.colors) != len(mesh.vertices):
        return None
    return to_linear(attributes.colors[:, :3] / 255.0)

"""The surface that carries a mark: each mesh of a scene once, however often it is shown (docs/decisions/0014)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from meshmark.geometry.shown import Shown
from meshmark.geometry.weld import Welded, weld
from meshmark.io.distinct import distinct
from meshmark.mesh import Mesh

__all__ = ["marked_surface", "surfaces_to_read"]


def marked_surface(mesh: Mesh) -> Welded:
    """Return the welded surface that an embedding into this mesh changes.

    That is one showing of each mesh where the mesh's file shows one several times; each vertex of the scene belongs
    to the point that it is an image of.
    """
    once = distinct(mesh)
    if once is None:
        return weld(mesh)
    welded = weld(once.mesh)
    return Shown(
        welded.points,
        welded.faces,
        welded.point_of_vertex[once.row],
        once.shown(welded),
        np.arange(len(welded.points)),
    )


def surfaces_to_read(mesh: Mesh) -> Iterator[Welded]:
    """Yield the surfaces that may carry the mark of a suspect, likeliest first."""
    first = marked_surface(mesh)
    yield first
    if isinstance(first, Shown):
        yield weld(mesh)

"""Where the points of marks go: some steps along the axes of their rings."""

from __future__ import annotations

import numpy as np

from meshmark.arrays import AnyIntArray
from meshmark.authentication.marks.candidates import level_of
from meshmark.authentication.marks.ring_shapes import RingShapes, frames, ring_shapes
from meshmark.authentication.marks.ring_ways import step_of
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.parameters import Style
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray

__all__ = ["moved_marks"]


def moved_marks(
    surface: Surface, unit: float, style: Style, marks: AnyIntArray, change: FloatArray
) -> FloatArray:
    """Return the points of a surface with those of marks moved.

    The axes are those in which the plain readings of the rings have the places of their points (`candidates`).

    Parameters
    ----------
    surface : Surface
        Of p points.
    unit : float
        Smallest step, in scene units.
    style : Style
        Of the marks.
    marks : (m,) int array
        Points, each once.
    change : (m, 3) float array
        How far each goes along the three axes of its ring, in steps.

    Returns
    -------
    (p, 3) float array
    """
    points = surface.points.copy()
    row_of = np.full(len(points), -1)
    row_of[marks] = np.arange(len(marks))
    for group in rings_of(surface):
        some = group.take(np.flatnonzero(row_of[group.vertex] >= 0))
        shapes = ring_shapes(surface.points, some, style)
        step = step_of(np.floor(level_of(shapes, unit)).astype(np.int64)) * shapes.size
        own = change[row_of[some.vertex]] * step[:, None]
        points[some.vertex] += np.einsum("rj,rji->ri", own, _axes(shapes))
    return points


def _axes(shapes: RingShapes) -> FloatArray:
    """Return (r, 3, 3): the axes of rings as rows, the farthest neighbour of each leading."""
    count = shapes.around.shape[1]
    order = (shapes.distance.argmax(axis=1)[:, None] + np.arange(count)) % count
    return frames(shapes.offsets(slice(None), order), shapes.normal)

"""How much of a surface shows its marks, and marks of authentication with words so short that they are not seen."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import replace

import numpy as np

from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.planning import Planned
from meshmark.authentication.parameters import Layout
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of
from meshmark.marking.bearing_plan import Borne, planned_marks
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.parts_telling import with_parts_telling
from meshmark.marking.unread_marks import SeenError
from meshmark.marking.written_marks import Base
from meshmark.mesh import Mesh
from meshmark.strengths import SHOWN_SHARES

__all__ = ["seen_share", "unseen"]

# Marks of shorter words are chosen anew and lie elsewhere: of the share that may be seen they are to show so much.
_ABOUT = 0.5

_SHORT = (
    "the marks of authentication have short words, and so carry less payload: longer ones would be seen on {:.0%} "
    "of the surface, as its edges are short beside what rounding does to its numbers"
)


def seen_share(original: Mesh, marked: Mesh) -> float:
    """Return the share of the surface, 0 to 1, where the marks of a mesh are visible (`geometry.visibility`)."""
    surface = surface_of(original)
    return surface.visible_change.of(marked.vertices[surface.vertex_of_point]).share


def unseen(base: Base, request: MarkRequest, marks: Borne) -> tuple[Borne, tuple[str, ...]]:
    """Return marks that are not seen, with the longest words of which that is so, and remarks about it.

    The same marks where these are not seen.

    Parameters
    ----------
    base : Base
    request : MarkRequest
    marks : Borne

    Returns
    -------
    marks : Borne
    remarks : tuple of str

    Raises
    ------
    SeenError
        Words of any length are seen.
    """
    most = SHOWN_SHARES[request.strength]
    share = seen_share(base.original, marks.written.mesh)
    if share <= most:
        return marks, ()
    planned = marks.written.planned
    shorter = [each for each in planned.precision.style.layouts if each.bits < planned.plan.layout.bits]
    first = bisect_left(shorter, True, key=lambda layout: _shown(base, marks, layout) <= _ABOUT * most)
    if first == len(shorter):
        raise SeenError(share)
    try:
        short = planned_marks(base, request, _with_layouts(base, request, planned, tuple(shorter[first:])))
    except CapacityError:
        raise SeenError(share) from None
    if seen_share(base.original, short.written.mesh) > most:
        raise SeenError(share)
    return short, (_SHORT.format(share),)


def _shown(base: Base, marks: Borne, layout: Layout) -> float:
    """Return the share of the surface that would show marks with words of another layout, about.

    Words of fewer bits have fewer levels, and marks move in proportion to their number.
    """
    written = marks.written
    before, after = base.mesh.vertices, written.mesh.vertices
    less = np.array(layout.radix) / np.array(written.planned.plan.layout.radix)
    factor = float(np.sqrt((less**2).mean()))
    return seen_share(base.original, written.mesh.with_vertices(before + factor * (after - before)))


def _with_layouts(base: Base, request: MarkRequest, planned: Planned, layouts: tuple[Layout, ...]) -> Planned:
    """Return the plan made anew with the first of these layouts that fits."""
    precision = replace(planned.precision, style=replace(planned.precision.style, layouts=layouts))
    again = plan(planned.plan.surface, request.key, precision.error, style=precision.style)
    return with_parts_telling(base, request, replace(planned, plan=again, precision=precision, content=None))

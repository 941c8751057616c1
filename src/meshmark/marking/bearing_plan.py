"""Plans of which marks fail under a promised rounding are mended before the marked model is examined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.rounded_marks import unread_when_rounded
from meshmark.authentication.marks.mending import mended
from meshmark.authentication.marks.planning import Planned
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.promises import rounded_by
from meshmark.marking.written_marks import Base, Written, write_marks
from meshmark.scene.distinct import scene_of

__all__ = ["bearing", "mended_plan"]

# How often marks are chosen anew, and the share of the points, or the number, that may be without one.
_TIMES, _FEW, _LEAST = 6, 1e-3, 2


def bearing(base: Base, request: MarkRequest, chosen: Planned) -> Written:
    """Return the marks of a plan, with others near points that promised roundings leave without one that is read.

    Of a model of a million points a few marks in a thousand fail in each rounding, and some of them leave a point
    alone. An examination finds that, too, but takes the longer the larger the model is. Where copies of one mesh
    are shown, each is rounded in its own way: the marks of the plan are returned as they are.

    Parameters
    ----------
    base : Base
    request : MarkRequest
    chosen : Planned

    Returns
    -------
    Written
        Bound to their places where they tell them.

    Raises
    ------
    CapacityError
        What the payload was asked to be does not fit.
    """
    written = write_marks(base, request, chosen, bound=chosen.plan.places_itself)
    if scene_of(chosen.mesh) is not None:
        return written
    avoid = np.zeros(len(chosen.plan.surface.points), bool)
    for _ in range(_TIMES):
        unread, failing = _unread(request, written)
        avoid |= failing
        again = mended_plan(request, written.planned, unread, avoid) if unread.any() else None
        if again is None:
            break
        written = write_marks(base, request, again, bound=again.plan.places_itself)
    return written


def mended_plan(
    request: MarkRequest, chosen: Planned, unread: NDArray[np.bool_], avoid: NDArray[np.bool_]
) -> Planned | None:
    """Return the plan with other marks near the points `unread` (p,), those of points to `avoid` (p,) last.

    None where these are many, or the others would not tell the model's id as the present ones do.
    """
    plan = chosen.plan
    if len(unread) != len(plan.surface.points) or unread.sum() > max(_FEW * len(unread), _LEAST):
        return None
    again = mended(plan, request.key, unread, avoid, chosen.precision.style)
    return replace(chosen, plan=again) if again.carries_id == plan.carries_id else None


def _unread(request: MarkRequest, written: Written) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which points no mark is read next to after some promised rounding, and which marks fail in some."""
    planned = written.planned
    surface, precision = planned.plan.surface, planned.precision
    unread, failing = np.zeros((2, len(surface.points)), bool)
    for _, vertices in rounded_by(written.mesh.vertices, precision.bears, precision.error):
        points = vertices[surface.vertex_of_point]
        found = unread_when_rounded(planned.plan, written.marked, points, request.key, precision.style)
        unread |= found[0]
        failing |= found[1]
    return unread, failing

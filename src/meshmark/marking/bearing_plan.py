"""Plans of which marks fail under a promised rounding are mended before the marked model is examined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.rounded_marks import unread_when_rounded
from meshmark.authentication.marks.mending import Doubts, few_enough, mended
from meshmark.authentication.marks.planning import Planned
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.promises import rounded_by
from meshmark.marking.written_marks import Base, Written, write_marks
from meshmark.scene.distinct import scene_of

__all__ = ["Borne", "bearing", "planned_marks"]

# How often marks are chosen anew.
_TIMES = 8


@dataclass(frozen=True, eq=False, kw_only=True)
class Borne:
    """Marks that promised roundings leave to be read, as far as their own rings tell, and what was seen on the way.

    written: the marks. ever, failing: (p,) as in `Doubts`, after one promised rounding or another.
    """

    written: Written
    ever: NDArray[np.bool_]
    failing: NDArray[np.bool_]

    def mended(self, base: Base, request: MarkRequest, unread: NDArray[np.bool_]) -> Borne | None:
        """Return other marks near the points `unread` (p,), written, and not looked at yet.

        None where there are many such points, or the other marks would not tell the model's id as these do.
        """
        chosen = self.written.planned
        if len(unread) != len(self.ever) or not few_enough(unread):
            return None
        doubts = Doubts(unread=unread, ever=self.ever | unread, failing=self.failing)
        again = mended(chosen.plan, request.key, doubts, chosen.precision.style)
        if again.carries_id != chosen.plan.carries_id:
            return None
        written = write_marks(base, request, replace(chosen, plan=again), bound=again.places_itself)
        return replace(self, written=written, ever=doubts.ever)

    def with_failing(self, passed: NDArray[np.bool_]) -> Borne:
        """Return it with the marks known that do not hold where marks were `passed` (p,)."""
        if len(passed) != len(self.failing):
            return self
        failing = self.failing.copy()
        marks = self.written.planned.plan.marks
        failing[marks[~passed[marks]]] = True
        return replace(self, failing=failing)


def planned_marks(base: Base, request: MarkRequest, chosen: Planned) -> Borne:
    """Return the marks of a plan, written, and not looked at yet.

    Raises
    ------
    CapacityError
        What the payload was asked to be does not fit.
    """
    nothing = np.zeros(len(chosen.plan.surface.points), bool)
    written = write_marks(base, request, chosen, bound=chosen.plan.places_itself)
    return Borne(written=written, ever=nothing, failing=nothing)


def bearing(base: Base, request: MarkRequest, marks: Borne) -> Borne:
    """Return marks, with others near points that promised roundings leave without one that is read.

    Of a model of a million points a few marks in a thousand fail in each rounding, and some of them leave a point
    alone. An examination finds that, too, but takes the longer the larger the model is. Where copies of one mesh
    are shown, each is rounded in its own way: the marks are returned as they are.

    Parameters
    ----------
    base : Base
    request : MarkRequest
    marks : Borne

    Returns
    -------
    Borne
        Bound to their places where they tell them.
    """
    if scene_of(marks.written.planned.mesh) is not None:
        return marks
    for _ in range(_TIMES):
        unread, seen = _unread(request, marks.written)
        marks = replace(marks, failing=marks.failing | seen)
        again = marks.mended(base, request, unread) if unread.any() else None
        if again is None:
            break
        marks = again
    return marks


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

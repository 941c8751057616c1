"""Other marks of authentication in small parts of an assembly that would not tell the id by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from meshmark.authentication.marks.candidates import joined
from meshmark.authentication.marks.plan import Plan, plan
from meshmark.authentication.marks.planning import Planned
from meshmark.authentication.marks.ring_room import covered
from meshmark.errors import CapacityError
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.marked_parts import tells_id
from meshmark.marking.written_marks import Base, write_marks
from meshmark.ownership.assembly_parts import AssemblyPart, assembly_parts
from meshmark.scene.distinct import scene_of

__all__ = ["with_parts_telling"]

# Parts of more points have marks enough that tell the id, and are not read while marks are chosen.
_SMALL = 1_500
# Other choices of marks that are tried in a part.
_CHOICES = 3


def with_parts_telling(base: Base, request: MarkRequest, chosen: Planned) -> Planned:
    """Return the plan with other marks in those small parts that tell the id by neither layer.

    Marks move a third of the points: beside one choice of them the id that a part has in its points is read, beside
    another it is not. On a surface in one piece, in a scene of copies, and without a layer below the plan stays as
    it is.

    Parameters
    ----------
    base : Base
    request : MarkRequest
    chosen : Planned

    Returns
    -------
    Planned

    Raises
    ------
    CapacityError
        What the payload was asked to be does not fit.
    """
    if base.below is None or scene_of(chosen.mesh) is not None:
        return chosen
    small = [part for part in assembly_parts(chosen.plan.surface) if len(part.rows) <= _SMALL]
    if not small:
        return chosen
    lost = _not_telling(base, request, chosen, small)
    for choice in range(1, _CHOICES + 1):
        if not lost:
            break
        with suppress(CapacityError):
            precision = chosen.precision
            other = plan(chosen.plan.surface, request.key, precision.error, choice, precision.style)
            tried = _mixed(chosen, other, lost)
            if tried is not None:
                left = _not_telling(base, request, tried, lost)
                better = _mixed(chosen, other, [part for part in lost if part not in left])
                chosen, lost = (chosen, lost) if better is None else (better, left)
    return chosen


def _not_telling(
    base: Base, request: MarkRequest, planned: Planned, parts: Sequence[AssemblyPart]
) -> list[AssemblyPart]:
    """Return those of the parts that do not tell the id once the marks are written."""
    mesh = write_marks(base, request, planned, bound=planned.plan.places_itself).mesh
    points = mesh.vertices[planned.plan.surface.vertex_of_point]
    surfaces = [part.surface(points) for part in parts]
    return [
        part
        for part, surface in zip(parts, surfaces, strict=True)
        if surface is not None and not tells_id(surface, request.key, request.id)
    ]


def _mixed(planned: Planned, other: Plan, parts: Sequence[AssemblyPart]) -> Planned | None:
    """Return a plan with the marks of another one in some parts.

    None where the marks are laid out in another way, or where together they would tell less of the id.
    """
    own = planned.plan
    inside = np.zeros(len(own.surface.points), bool)
    for part in parts:
        inside[part.rows] = True
    found = joined([own.found.take(~inside[own.found.vertex]), other.found.take(inside[other.found.vertex])])
    marks = np.zeros(len(inside), bool)
    marks[found.vertex] = True
    mixed = replace(own, found=found, covered=covered(own.surface, marks))
    if other.layout != own.layout or mixed.carries_id != own.carries_id or mixed.once < own.once:
        return None
    return replace(planned, plan=mixed)

"""The authentication layer of an embedding: planned, written and read back on top of what is there already."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from meshmark.authentication.examination import examine
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.planning import Planned, plans
from meshmark.authentication.payload.content import content_for
from meshmark.authentication.payload.payload import encoder, unpack
from meshmark.authentication.payload.signed_totals import whole_of
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.io.file_precision import conform
from meshmark.marking.embedding_result import AuthenticationMark
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.promises import broken_by
from meshmark.marking.verification import authentic
from meshmark.mesh import Mesh
from meshmark.scene.distinct import as_shown, scene_of

__all__ = ["Authenticated", "Base", "with_authentication"]

# Choices of marks that are looked at for each precision, and how many of those that carry the id are made and read
# back. Most choices of a small model leave out a piece of the id.
_CHOICES, _READ = 8, 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Base:
    """What the layer goes onto.

    original: the unmarked mesh, whose file rounds positions. mesh: the same with the layer below, if there is one.
    has_id: the layer below carries the id, so that this one need not.
    """

    original: Mesh
    mesh: Mesh
    has_id: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Authenticated:
    """A mesh with marks of authentication, and remarks about what was given up for them."""

    mesh: Mesh
    mark: AuthenticationMark
    remarks: tuple[str, ...]


def with_authentication(base: Base, request: MarkRequest) -> Authenticated:
    """Return the first marks that are read back as they should, and survive what their tolerance promises.

    For each precision a few keyed choices of points are tried, as some leave a point without a voucher.

    Parameters
    ----------
    base : Base
    request : MarkRequest
        Key, id, payload and tolerance.

    Returns
    -------
    Authenticated

    Raises
    ------
    CapacityError
        No marks fit; the message says why the last ones do not.
    """
    refusal = CapacityError("no marks of authentication fit, expected more room for payload")
    for planned in plans(base.mesh, request.key, request.tolerance):
        carrying = (each for each in _choices(planned, request.key) if each.plan.carries_id or base.has_id)
        refusal = CapacityError("the model has room for too few marks of authentication to tell its id")
        try:
            for chosen in islice(carrying, _READ):
                try:
                    return _bound_or_not(base, request, chosen)
                except _UnreadError as error:
                    refusal = error
        except CapacityError as error:
            refusal = error
    raise refusal


def _bound_or_not(base: Base, request: MarkRequest, chosen: Planned) -> Authenticated:
    """Return marks whose symbols are bound to their places; where these are not found again, marks that are not."""
    if chosen.plan.places_itself:
        with suppress(_UnplacedError):
            return _marked(base, request, chosen, bound=True)
    return _marked(base, request, chosen, bound=False)


class _UnreadError(CapacityError):
    """The marks of authentication are not read back as they should."""


class _UnplacedError(_UnreadError):
    """The marks hold, but do not tell where the model lies, so that the payload bound to places is not read."""


def _choices(planned: Planned, key: Key) -> Iterator[Planned]:
    """Yield the plan, then those of other keyed choices of points."""
    yield planned
    surface, precision = planned.plan.surface, planned.precision
    for choice in range(1, _CHOICES):
        yield replace(planned, plan=plan(surface, key, precision.error, choice, precision.style))


def _marked(base: Base, request: MarkRequest, planned: Planned, *, bound: bool) -> Authenticated:
    """Return the marks of one plan; raises `CapacityError` where they do not hold.

    bound: their symbols are bound to their places, which the marks of small models cannot tell.
    """
    surface, precision = planned.plan.surface, planned.precision
    symbols, symbol_bits = len(np.unique(planned.plan.payload_index)), planned.plan.symbol_bits
    web = not precision.style.pull
    whole = whole_of(surface, precision.error, scene_of(planned.mesh), web=web)
    whole = replace(whole, shown=request.shown, once=planned.plan.once)
    packed, remarks = content_for(request.content, surface, whole, symbols, symbol_bits)
    source = encoder(packed, symbol_bits, symbols)
    marked = mark(planned.plan, request.key, request.id, source, bound=bound)
    moved = (marked.points != surface.points).any(axis=1)[surface.point_of_vertex]
    vertices = np.where(moved[:, None], marked.points[surface.point_of_vertex], planned.mesh.vertices)
    result = planned.mesh.with_vertices(conform(base.original, vertices))
    surface_of_moved(
        result, planned.mesh
    )  # remembered, so that `examine` welds only what rounding has joined
    found = examine(as_shown(result), request.key, made=request.id)
    if bound and found.marked and found.payload is None:
        raise _UnplacedError("the marks of authentication do not tell where the model lies")
    if not authentic(found, request.id):
        raise _UnreadError(
            "the marks of authentication cannot be read back from the positions the file can hold"
        )
    if found.payload != unpack(packed):
        raise _UnreadError("the payload cannot be read back from the marked model")
    broken = broken_by(result, request.key, request.id, precision.bears, precision.error)
    if broken is not None:
        raise CapacityError(
            f"the marks of authentication would not survive {broken}, as the tolerance promises"
        )
    if precision.remark is not None:
        remarks += (precision.remark,)
    made = AuthenticationMark(
        marks=marked.count,
        payload_bytes=len(unpack(packed).content),
        tolerance=request.tolerance or "default",
    )
    return Authenticated(mesh=result, mark=made, remarks=remarks)

"""Marks of authentication as they are written into a mesh, before anything of them is read back."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from meshmark.authentication.marks.plan import Marked, mark
from meshmark.authentication.marks.planning import Planned
from meshmark.authentication.marks.signed_word import signed_word
from meshmark.authentication.payload.content import content_for
from meshmark.authentication.payload.payload import Payload, SymbolSource, encoder, unpack
from meshmark.authentication.payload.signed_totals import Whole, whole_of
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.io.file_precision import conform
from meshmark.marking.mark_request import MarkRequest
from meshmark.mesh import Mesh
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.scene.distinct import scene_of

__all__ = ["Base", "Written", "write_marks"]

_NO_PAYLOAD = (
    "the model is too small for a payload beside its marks of authentication, so no part can be recovered"
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Base:
    """What the layer goes onto.

    original: the unmarked mesh, whose file rounds positions. mesh: the same with the layer below, if there is one.
    below: the mark of the layer below, which carries the id, so that this one need not; None without one.
    """

    original: Mesh
    mesh: Mesh
    below: OwnershipMark | None

    @property
    def has_id(self) -> bool:
        """Whether the layer below carries the id."""
        return self.below is not None


@dataclass(frozen=True, eq=False, kw_only=True)
class Written:
    """planned: with the content that was made for it. mesh: with the marks of the plan, `marked`, as its file can
    hold them; bound: to their places. payload: what they carry, and remarks about what was left out of it.
    """

    planned: Planned
    mesh: Mesh = field(repr=False)
    marked: Marked = field(repr=False)
    bound: bool
    payload: Payload
    remarks: tuple[str, ...]


def write_marks(base: Base, request: MarkRequest, planned: Planned, *, bound: bool) -> Written:
    """Return the marks of a plan in the mesh.

    Parameters
    ----------
    base : Base
    request : MarkRequest
        Key, id, payload and tolerance.
    planned : Planned
    bound : bool
        Their symbols are bound to their places, which the marks of small models cannot tell.

    Returns
    -------
    Written

    Raises
    ------
    CapacityError
        What the payload was asked to be does not fit.
    """
    surface, precision = planned.plan.surface, planned.precision
    web = not precision.style.pull
    whole = whole_of(surface, precision.error, scene_of(planned.mesh), web=web)
    whole = replace(whole, shown=request.shown, once=planned.plan.once)
    payload, source, remarks = _payload(planned, request, whole)
    nonce = request.id
    if planned.plan.layout.pieces_only:
        nonce = signed_word(request.key, request.id, whole.points)
    marked = mark(planned.plan, request.key, nonce, source, bound=bound)
    moved = (marked.points != surface.points).any(axis=1)[surface.point_of_vertex]
    vertices = np.where(moved[:, None], marked.points[surface.point_of_vertex], planned.mesh.vertices)
    mesh = planned.mesh.with_vertices(conform(base.original, vertices))
    # Remembered, so that a reader welds only what rounding has joined.
    surface_of_moved(mesh, planned.mesh)
    return Written(
        planned=replace(planned, content=payload.content),
        mesh=mesh,
        marked=marked,
        bound=bound,
        payload=payload,
        remarks=remarks,
    )


def _payload(
    planned: Planned, request: MarkRequest, whole: Whole
) -> tuple[Payload, SymbolSource, tuple[str, ...]]:
    """Return the payload as it will be read back, its symbols, and remarks about what was left out."""
    plan = planned.plan
    if plan.layout.pieces_only:
        signed = Payload(kind="none", content=b"", whole=Whole(points=whole.points))
        return signed, lambda index: np.zeros(len(index), np.uint16), (_NO_PAYLOAD,)
    symbols = len(np.unique(plan.payload_index))
    packed, remarks = content_for(
        request.content, plan.surface, whole, (symbols, plan.symbol_bits), made=planned.content
    )
    return unpack(packed), encoder(packed, plan.symbol_bits, symbols), remarks

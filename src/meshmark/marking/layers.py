"""Embedding of both layers: the ownership mark first, the marks of authentication and the payload on top of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from math import inf, log10
from time import perf_counter

import numpy as np

from meshmark.authentication.examination import examine
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.planning import Planned, plans
from meshmark.authentication.payload.content import Asked, Content, content_for, content_of
from meshmark.authentication.payload.payload import encoder, unpack
from meshmark.authentication.payload.signed_totals import whole_of
from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.errors import CapacityError, InputError
from meshmark.io.save import conform
from meshmark.marking.promises import broken_by
from meshmark.marking.repeated_mesh import as_scene
from meshmark.marking.repeated_mesh import embed_repeated as embed_ownership
from meshmark.marking.undo import sealed
from meshmark.marking.verification import authentic, verify
from meshmark.mesh import Mesh
from meshmark.ownership.embedding import diagonal_of, displacement_rms
from meshmark.ownership.extraction import extract
from meshmark.ownership.parameters import SPACINGS, STEPS
from meshmark.ownership.results import Embedding
from meshmark.scene.distinct import as_shown, distinct, scene_of
from meshmark.strengths import BUDGETS
from meshmark.threads import on_one_thread

__all__ = ["LAYERS", "embed"]

LAYERS = ("both", "ownership", "authentication")
# So many choices of marks are looked at for a precision, and so many that tell the id made and read back. Most of
# the choices of a small model leave out a piece of the id.
_CHOICES, _READ = 8, 3
# Room for the upper layer is measured on a surface that then changes a little.
_MORE = 1.1


@on_one_thread
def embed(
    mesh: Mesh,
    key: Key,
    *,
    id: int | None = None,
    strength: str = "standard",
    layers: str | None = None,
    payload: Content = None,
    tolerance: str | None = None,
) -> Embedding:
    """Return `mesh` carrying a 64-bit id, and marks that tell what was changed later, under `key`.

    id: drawn where there is none. strength: "subtle", "standard" or "strong", an RMS displacement of at most 0.02,
    0.08 or 0.2 % of the bounding-box diagonal by all layers together, in the positions that the file can hold.
    layers: "both", "ownership" (the id alone, which survives damage), or "authentication"; None: both, or ownership
    alone where the model has no room for authentication, which a remark then says.
    payload: "miniature" (of the model, for its recovery), "none", bytes, or the path of a file; None: a miniature,
    or none where it does not fit.
    tolerance: "strict", or "tolerant" of exports that round coordinates to 16 bits or six digits; "default": of six
    digits where the payload need not suffer (`precisions_of`); None: the same, but the layer may be left out.

    All is read back blind before this returns. Raises `InputError` for arguments that cannot be used,
    `CapacityError` where the mesh cannot carry what is asked for.
    """
    start = perf_counter()
    _check(strength, layers)
    once = distinct(mesh)  # copies of one mesh are marked as one
    if once is not None:
        mesh = once.mesh
    content = content_of(payload)
    identity = random_id() if id is None else check_id(id)
    if layers == "ownership":
        if tolerance is not None:
            raise InputError(
                "a tolerance is one of authentication marks, expected layers both or authentication"
            )
        if payload is not None and content.kind != "none":
            raise InputError(
                "a payload needs the authentication layer, expected layers both or authentication"
            )
        result = embed_ownership(mesh, key, id=identity, strength=strength)
        verify(result.mesh, key, result)
    elif layers == "authentication":
        result = _on_top(_unmarked(mesh, identity, strength), mesh, key, content, tolerance)
    else:
        try:
            result = _both(mesh, key, identity, strength, content, tolerance)
        except _NoRoomError as error:
            if layers is not None or payload is not None or tolerance is not None:
                raise CapacityError(str(error)) from None
            result = replace(error.below, remarks=(f"the authentication layer is left out: {error}",))
            verify(result.mesh, key, result)
    seal = partial(sealed, original=mesh, marked=result.mesh, key=key, identity=identity)
    result = replace(result, seconds=perf_counter() - start, seal=seal)
    return result if once is None else as_scene(result, once)


class _NoRoomError(CapacityError):
    """The upper layer does not fit on the one below."""

    def __init__(self, below: Embedding, reason: str) -> None:
        super().__init__(reason)
        self.below = below


@dataclass(frozen=True, eq=False, kw_only=True)
class _Upper:
    mesh: Mesh
    count: int
    payload_bytes: int
    remarks: tuple[str, ...]


def _check(strength: str, layers: str | None) -> None:
    if strength not in BUDGETS:
        raise InputError(f"unknown strength '{strength}', expected one of {', '.join(BUDGETS)}")
    if layers is not None and layers not in LAYERS:
        raise InputError(f"unknown layers '{layers}', expected one of {', '.join(LAYERS)}")


def _unmarked(mesh: Mesh, identity: int, strength: str) -> Embedding:
    """Return what stands below an authentication layer that is alone; spacing and step mean nothing there."""
    n, m = len(mesh.vertices), len(mesh.faces)
    return Embedding(
        mesh=mesh,
        id=identity,
        layers="authentication",
        vertices=n,
        faces=m,
        carriers=0,
        mark_vertices=0,
        payload_bytes=0,
        rms_over_diagonal=0.0,
        max_over_diagonal=0.0,
        psnr_db=inf,
        verified=True,
        seconds=0.0,
        strength=strength,
        spacing=SPACINGS[0],
        step=STEPS[0],
    )


def _both(
    mesh: Mesh, key: Key, identity: int, strength: str, content: Asked, tolerance: str | None
) -> Embedding:
    """Return both layers; a second time with less of the budget for the lower one where the first is too much."""
    try:
        below = embed_ownership(mesh, key, id=identity, strength=strength)
    except CapacityError as error:
        raise CapacityError(f"{error}{_authentication_alone(mesh, key, tolerance)}") from None
    try:
        return _on_top(below, mesh, key, content, tolerance)
    except _OverBudgetError as error:
        reserve = _MORE * error.share
        if reserve >= BUDGETS[strength]:
            raise _NoRoomError(below, str(error)) from None
        below = embed_ownership(mesh, key, id=identity, strength=strength, reserve=reserve)
        try:
            return _on_top(below, mesh, key, content, tolerance)
        except CapacityError as again:
            raise _NoRoomError(below, str(again)) from None
    except CapacityError as error:
        raise _NoRoomError(below, str(error)) from None


def _authentication_alone(mesh: Mesh, key: Key, tolerance: str | None) -> str:
    """Return what to add to the refusal of the id where there is room for the marks of authentication."""
    try:
        fits = next(plans(mesh, key, tolerance), None) is not None
    except CapacityError:
        fits = False
    return "; for --layers authentication, without an id that survives damage, there is room" if fits else ""


class _OverBudgetError(CapacityError):
    """The upper layer moves the surface by this RMS over the diagonal, too much beside the lower one."""

    def __init__(self, share: float, strength: str) -> None:
        super().__init__(
            f"the marks of authentication move vertices by {100 * share:.2g} % of the diagonal RMS, as the model's "
            f"file or its size calls for: beside the id too much for strength {strength}"
        )
        self.share = share


def _on_top(below: Embedding, original: Mesh, key: Key, content: Asked, tolerance: str | None) -> Embedding:
    """Return the result with the authentication layer on it, read back."""
    upper = _marked(below, original, key, content, tolerance)
    diagonal = diagonal_of(original)
    rms = displacement_rms(original, upper.mesh)
    if rms > BUDGETS[below.strength] * diagonal:
        raise _OverBudgetError(displacement_rms(below.mesh, upper.mesh) / diagonal, below.strength)
    carriers = below.carriers
    layers = "authentication"
    if carriers:
        layers = "both"
        found = extract(upper.mesh, key, search="plain")
        if found.id != below.id:
            raise CapacityError("the id cannot be read beside the marks of authentication")
        carriers = found.carriers
    largest = float(np.linalg.norm(upper.mesh.vertices - original.vertices, axis=1).max())
    return replace(
        below,
        mesh=upper.mesh,
        layers=layers,
        carriers=carriers,
        mark_vertices=upper.count,
        payload_bytes=upper.payload_bytes,
        rms_over_diagonal=rms / diagonal,
        max_over_diagonal=largest / diagonal,
        psnr_db=20.0 * log10(diagonal / rms) if rms > 0.0 else inf,
        remarks=upper.remarks,
    )


def _marked(below: Embedding, original: Mesh, key: Key, content: Asked, tolerance: str | None) -> _Upper:
    """Return the first marks that are read back as they should, and bear what they are promised to.

    For each precision a few choices are tried, as some leave a point without a voucher.
    """
    refusal = CapacityError("no marks of authentication fit, expected more room for payload")
    for planned in plans(below.mesh, key, tolerance):
        telling = (each for each in _choices(planned, key) if each.plan.tells_id or below.carriers)
        refusal = CapacityError("the model has room for too few marks of authentication to tell its id")
        try:
            for chosen in islice(telling, _READ):
                try:
                    return _marked_for(below, original, key, content, chosen)
                except _UnreadError as error:
                    refusal = error
        except CapacityError as error:
            refusal = error
    raise refusal


def _choices(planned: Planned, key: Key) -> Iterator[Planned]:
    """Yield the plan, then those of other keyed choices of points."""
    yield planned
    for choice in range(1, _CHOICES):
        other = plan(planned.surface, key, planned.precision.error, choice)
        yield replace(planned, plan=other, choice=choice)


class _UnreadError(CapacityError):
    """The marks of authentication are not read back as they should."""


def _marked_for(below: Embedding, original: Mesh, key: Key, content: Asked, planned: Planned) -> _Upper:
    mesh, surface, precision = planned.mesh, planned.surface, planned.precision
    symbols, symbol_bits = len(np.unique(planned.plan.payload_index)), planned.plan.symbol_bits
    whole = whole_of(surface, precision.error, scene_of(mesh))
    packed, remarks = content_for(content, surface, whole, symbols, symbol_bits)
    source = encoder(packed, symbol_bits, symbols)
    marked = mark(surface, key, below.id, source, precision.error, choice=planned.choice)
    moved = (marked.points != surface.points).any(axis=1)[surface.point_of_vertex]
    vertices = np.where(moved[:, None], marked.points[surface.point_of_vertex], mesh.vertices)
    result = mesh.with_vertices(conform(original, vertices))
    if not authentic(found := examine(as_shown(result), key), below.id):
        raise _UnreadError(
            "the marks of authentication cannot be read back from the positions the file can hold"
        )
    if found.payload != unpack(packed):
        raise _UnreadError("the payload cannot be read back from the marked model")
    broken = broken_by(result, key, below.id, precision.bears, precision.error)
    if broken is not None:
        raise CapacityError(
            f"the marks of authentication would not survive {broken}, as the tolerance promises"
        )
    if precision.remark is not None:
        remarks += (precision.remark,)
    return _Upper(mesh=result, count=marked.count, payload_bytes=len(unpack(packed).content), remarks=remarks)

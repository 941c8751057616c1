"""Embedding of both layers: the ownership mark first, the marks of authentication and the payload on top of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import inf, log10
from time import perf_counter

import numpy as np

from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import Welded, weld
from meshmark.io.distinct import distinct, scene_of
from meshmark.io.save import conform
from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.authentication.checks import Checks, check
from meshmark.schemes.ncdg_lv.authentication.content import Asked, Content, content_for, content_of
from meshmark.schemes.ncdg_lv.authentication.localisation import altered_points
from meshmark.schemes.ncdg_lv.authentication.marks import Plan, mark, plan
from meshmark.schemes.ncdg_lv.authentication.payload import capacity, decode, encoder, unpack
from meshmark.schemes.ncdg_lv.authentication.precision import Precision, precisions_of
from meshmark.schemes.ncdg_lv.authentication.whole import whole_of
from meshmark.schemes.ncdg_lv.copies import as_scene
from meshmark.schemes.ncdg_lv.copies import embed_repeated as embed_ownership
from meshmark.schemes.ncdg_lv.embedding import diagonal_of, displacement_rms
from meshmark.schemes.ncdg_lv.extraction import extract
from meshmark.schemes.ncdg_lv.parameters import BUDGETS, SPACINGS, STEPS
from meshmark.schemes.ncdg_lv.results import Embedding
from meshmark.schemes.ncdg_lv.threads import on_one_thread
from meshmark.schemes.ncdg_lv.undo import sealed

__all__ = ["LAYERS", "embed", "still_authentic"]

LAYERS = ("both", "ownership", "authentication")
# Marks for a coarser precision are taken where they cover so much of the points, or of what the finer ones do.
_COVERED = 0.9
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
    tolerance: "strict", or "tolerant" of exports that round coordinates to 16 bits or six digits; None: of six
    digits where the payload need not suffer (`precisions_of`).

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
        if payload is not None and content.kind != "none":
            raise InputError(
                "a payload needs the authentication layer, expected layers both or authentication"
            )
        result = embed_ownership(mesh, key, id=identity, strength=strength)
    elif layers == "authentication":
        result = _on_top(_unmarked(mesh, identity, strength), mesh, key, content, tolerance)
    else:
        try:
            result = _both(mesh, key, identity, strength, content, tolerance)
        except _NoRoomError as error:
            if layers is not None or payload is not None:
                raise CapacityError(str(error)) from None
            result = replace(error.below, remarks=(f"the authentication layer is left out: {error}",))
    seal = partial(sealed, original=mesh, marked=result.mesh, key=key, identity=identity)
    result = replace(result, seconds=perf_counter() - start, seal=seal)
    return result if once is None else as_scene(result, once)


class _NoRoomError(CapacityError):
    """The upper layer does not fit on the one below."""

    def __init__(self, below: Embedding, reason: str) -> None:
        super().__init__(reason)
        self.below = below


@dataclass(frozen=True, eq=False)
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
        mesh,
        identity,
        "authentication",
        n,
        m,
        0,
        0,
        0,
        0.0,
        0.0,
        inf,
        True,
        0.0,
        strength,
        SPACINGS[0],
        STEPS[0],
    )


def _both(
    mesh: Mesh, key: Key, identity: int, strength: str, content: Asked, tolerance: str | None
) -> Embedding:
    """Return both layers; a second time with less of the budget for the lower one where the first is too much."""
    below = embed_ownership(mesh, key, id=identity, strength=strength)
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
        found = extract(upper.mesh, key, locking=False)
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
    mesh = below.mesh
    surface = weld(mesh)
    planned, precision = _planned(mesh, surface, key, tolerance)
    symbols = len(np.unique(planned.payload_index))
    packed, remarks = content_for(
        content, surface, whole_of(surface, precision.error, scene_of(mesh)), symbols, planned.symbol_bits
    )
    source = encoder(packed, planned.symbol_bits, symbols)
    marked = mark(surface, key, below.id, source, precision.error)
    moved = (marked.points != surface.points).any(axis=1)[surface.point_of_vertex]
    vertices = np.where(moved[:, None], marked.points[surface.point_of_vertex], mesh.vertices)
    result = mesh.with_vertices(conform(original, vertices))
    _read_back(result, key, below.id, packed, known=below.carriers > 0)
    if precision.remark is not None:
        remarks += (precision.remark,)
    return _Upper(result, marked.count, len(unpack(packed).content), remarks)


def _planned(mesh: Mesh, surface: Welded, key: Key, tolerance: str | None) -> tuple[Plan, Precision]:
    """Return the marks for the coarsest precision that leaves room for what it must, and that they can cover."""
    tried: list[tuple[Plan, Precision]] = []
    refusal: CapacityError | None = None
    for precision in precisions_of(mesh, tolerance):
        try:
            planned = plan(surface, key, precision.error)
        except CapacityError as error:
            refusal = error
            continue
        if 8 * capacity(planned.payload_marks, planned.symbol_bits) < precision.enough * len(surface.points):
            continue
        tried.append((planned, precision))
        if planned.covered >= _COVERED:
            break
    if not tried:
        raise refusal or CapacityError("no marks of authentication fit, expected more room for payload")
    most = max(planned.covered for planned, _ in tried)
    return next(pair for pair in tried if pair[0].covered >= _COVERED * most)


def _read_back(mesh: Mesh, key: Key, identity: int, packed: bytes, *, known: bool) -> None:
    surface = weld(mesh)
    found = _checks(surface, key, identity, known)
    if not _holds(surface, found, identity):
        raise CapacityError(
            "the marks of authentication cannot be read back from the positions the file can hold"
        )
    if decode(found.index, found.value, found.symbol_bits) != packed:
        raise CapacityError("the payload cannot be read back from the marked model")


def still_authentic(surface: Welded, key: Key, identity: int, *, known: bool) -> bool:
    """Return whether the marks of a surface tell this id and no alteration; `known`: so does the layer below."""
    return _holds(surface, _checks(surface, key, identity, known), identity)


def _checks(surface: Welded, key: Key, identity: int, known: bool) -> Checks:
    """Check as `authenticate` does: where the marks of a small model do not tell the id, the layer below may."""
    found = check(surface, key)
    return check(surface, key, identity) if known and found.nonce is None else found


def _holds(surface: Welded, found: Checks, identity: int) -> bool:
    return found.nonce == identity and not altered_points(surface, found).any()

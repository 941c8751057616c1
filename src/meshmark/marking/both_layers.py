"""Embedding of both layers: the ownership mark first, the marks of authentication and the payload on top of it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from time import perf_counter

from meshmark.authentication.marks.planning import plans
from meshmark.authentication.payload.content import Content
from meshmark.authentication.shown_otherwise import packed_deviations
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, told_id
from meshmark.errors import CapacityError
from meshmark.marking.authentication_layer import with_authentication
from meshmark.marking.embedding_result import Embedding
from meshmark.marking.fewer_bits import fewer_bits_that_fit
from meshmark.marking.mark_request import WEB_FORMATS, MarkRequest
from meshmark.marking.marked_parts import parts_in_words, parts_read
from meshmark.marking.repeated_mesh import embed_repeated
from meshmark.marking.unread_marks import SeenError
from meshmark.marking.unseen_words import seen_share
from meshmark.marking.verification import verify
from meshmark.marking.written_marks import Base
from meshmark.mesh import Mesh
from meshmark.ownership.embedding import Owned
from meshmark.ownership.vertex_displacement import displacement_rms, vertex_displacement
from meshmark.scene.distinct import distinct
from meshmark.strengths import BUDGETS, SHOWN_SHARES
from meshmark.threads import on_one_thread

__all__ = ["embed", "embed_for"]

# Room for the upper layer is measured on a surface that then changes a little.
_MORE = 1.1
_UNSIGNED = (
    f"the authentication layer is left out: its marks are signed with an id of {ID_BITS} bits, so nothing tells "
    "what is changed later"
)
_PRICE = (
    "the marks of authentication bear exports that round positions to 14 bits, as web pipelines do, and so carry "
    "less payload; --tolerance default has more, but loses its marks in such exports"
)

_SEEN_LESS = (
    "the marks of authentication have short words, as those of --tolerance web, and so carry less payload: longer "
    "ones would be seen on {:.0%} of the surface, as the model's numbers are small"
)
_SEEN = (
    "the marks are seen on {:.0%} of the surface; the id alone (--layers ownership) shows less, and so may "
    "--tolerance web, or the model in smaller units"
)


@on_one_thread
def embed(
    mesh: Mesh,
    key: Key,
    *,
    id: int | None = None,
    bits: int = ID_BITS,
    strength: str = "standard",
    layers: str | None = None,
    payload: Content = None,
    tolerance: str | None = None,
) -> Embedding:
    """Mark a mesh with an id, and with marks that show what is changed later; read everything back blind.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    id : int, optional
        Of so many bits; drawn at random where it is left out.
    bits : int
        64; or, for models too small for it, 32, a registry's serial number, or 0, a mark without an id, which says
        that it is there. With 32 and 0 there are no marks of authentication.
    strength : str
        "subtle", "standard" or "strong": an RMS displacement of at most 0.02, 0.08 or 0.2 % of the bounding-box
        diagonal by all layers together, in the positions that the file can hold.
    layers : str, optional
        "both", "ownership" (the id alone, which survives damage), or "authentication". By default both, or
        ownership alone where the model has no room for authentication, which a remark then says.
    payload : str, bytes or path, optional
        "miniature" (of the model, for its recovery), "none", bytes, or the path of a file. By default a miniature,
        or none where it does not fit.
    tolerance : str, optional
        "strict", "tolerant" of exports that round coordinates to 16 bits or six digits, or "web", of those that
        round them to 14 bits, as web pipelines do; "default": of six digits where the payload need not suffer
        (`precisions_of`). Without it, "web" for a glTF where there is room, and where other marks would be seen,
        else "default", but the layer may be left out.

    Returns
    -------
    Embedding

    Raises
    ------
    InputError
        An argument cannot be used.
    CapacityError
        The mesh cannot carry what is asked for.
    """
    start = perf_counter()
    request = MarkRequest.checked(
        key, id=id, bits=bits, strength=strength, layers=layers, payload=payload, tolerance=tolerance
    )
    goes_to = None if mesh.document is None else mesh.document.format
    return replace(embed_for(mesh, request, goes_to), seconds=perf_counter() - start)


@on_one_thread
def embed_for(mesh: Mesh, request: MarkRequest, goes_to: str | None) -> Embedding:
    """Mark a mesh as requested for a file of a format, a key of `io.FORMATS`; None for no file.

    Raises what `embed` raises.
    """
    from meshmark.marking.undo import sealed

    start = perf_counter()
    web = request.tolerance is None and goes_to in WEB_FORMATS
    request = replace(request, shown=packed_deviations(mesh.document), web_first=web)
    once = distinct(mesh)  # copies of one mesh are marked as one
    original = mesh if once is None else once.mesh
    made = _marked(original, request)
    seal = partial(sealed, original=original, marked=made.mesh, key=request.key, identity=request.id)
    if once is not None:
        whole = once.whole(made.mesh.vertices)
        made = replace(made, mesh=whole, displacement=vertex_displacement(once.scene, whole))
    return replace(made, seconds=perf_counter() - start, seal=seal)


class _NoRoomError(CapacityError):
    """The upper layer does not fit on the one below."""

    def __init__(self, below: Owned, reason: str) -> None:
        super().__init__(reason)
        self.below = below


class _OverBudgetError(CapacityError):
    """The upper layer moves the surface by this RMS over the diagonal, too much beside the lower one."""

    def __init__(self, share: float, strength: str) -> None:
        super().__init__(
            f"the marks of authentication move vertices by {100 * share:.2g} % of the diagonal RMS, as the model's "
            f"file or its size calls for: beside the id too much for strength {strength}"
        )
        self.share = share


def _marked(mesh: Mesh, request: MarkRequest) -> Embedding:
    """Return the layers that are asked for, read back."""
    if request.layers == "authentication":
        return _first_that_fits(None, mesh, request)
    if request.bits != ID_BITS:
        left = () if request.layers else (_UNSIGNED,)
        return _verified(_with_id(mesh, request), mesh, request, remarks=left)
    if request.layers == "ownership":
        return _verified(_with_id(mesh, request), mesh, request)
    try:
        return _both(mesh, request)
    except _NoRoomError as error:
        if not request.optional:
            raise CapacityError(str(error)) from None
        return _verified(
            error.below, mesh, request, remarks=(f"the authentication layer is left out: {error}",)
        )


def _with_id(mesh: Mesh, request: MarkRequest, reserve: float = 0.0) -> Owned:
    """Return the mark of the lower layer; a refusal says with how many bits fewer it would fit."""
    try:
        return embed_repeated(mesh, request.key, id=request.id, strength=request.strength, reserve=reserve)
    except CapacityError as error:
        raise CapacityError(f"{error}{fewer_bits_that_fit(mesh, request)}") from None


def _verified(below: Owned, mesh: Mesh, request: MarkRequest, remarks: tuple[str, ...] = ()) -> Embedding:
    """Return the ownership layer alone, verified."""
    result = Embedding(
        mesh=below.mesh,
        id=told_id(request.id),
        strength=request.strength,
        ownership=below.mark,
        authentication=None,
        displacement=vertex_displacement(mesh, below.mesh),
        remarks=(*remarks, *parts_in_words(len(below.mark.parts), below.mark.bits)),
    )
    verify(result.mesh, request.key, result)
    return result


def _both(mesh: Mesh, request: MarkRequest) -> Embedding:
    """Return both layers; a second time with less of the budget for the lower one where the first is too much."""
    try:
        below = _with_id(mesh, request)
    except CapacityError as error:
        raise CapacityError(f"{error}{_authentication_alone(mesh, request)}") from None
    try:
        return _first_that_fits(below, mesh, request)
    except CapacityError as error:
        raise _NoRoomError(below, str(error)) from None


def _first_that_fits(below: Owned | None, mesh: Mesh, request: MarkRequest) -> Embedding:
    """Return the authentication layer with the first tolerance that fits; a remark says what it costs or lacks."""
    if not request.web_first:
        return _less_seen(below, mesh, request)
    try:
        made = _told_if_seen(_within_budget(below, mesh, replace(request, tolerance="web")), mesh)
        remark = _PRICE
    except CapacityError as error:
        made = _less_seen(below, mesh, request)
        remark = f"exports that round positions to 14 bits, as web pipelines do, break the marks: {error}"
    return replace(made, remarks=(*made.remarks, remark))


def _less_seen(below: Owned | None, mesh: Mesh, request: MarkRequest) -> Embedding:
    """Return the layer, of words so short that it is not seen, where no tolerance is named.

    Six decimals are coarse for a model of small numbers, and marks of long words move further to bear them. Where
    words of any length are seen those of "web" are taken, if they are seen less, and were not tried first.
    """
    if request.tolerance is None:
        try:
            return _within_budget(below, mesh, replace(request, unseen=True))
        except SeenError as error:
            share = error.share
        if not request.web_first:
            with suppress(CapacityError):
                other = _within_budget(below, mesh, replace(request, tolerance="web"))
                if seen_share(mesh, other.mesh) < share:
                    return replace(other, remarks=(*other.remarks, _SEEN_LESS.format(share)))
    return _told_if_seen(_within_budget(below, mesh, request), mesh)


def _told_if_seen(made: Embedding, mesh: Mesh) -> Embedding:
    """Return the marks, with a remark where more of the surface shows them than the strength promises."""
    share = seen_share(mesh, made.mesh)
    if share <= SHOWN_SHARES[made.strength]:
        return made
    return replace(made, remarks=(*made.remarks, _SEEN.format(share)))


def _within_budget(below: Owned | None, mesh: Mesh, request: MarkRequest) -> Embedding:
    """Return the layer on the one below, which is made anew with less of the budget where both are too much."""
    try:
        return _on_top(below, mesh, request)
    except _OverBudgetError as error:
        reserve = _MORE * error.share
        if below is None or reserve >= BUDGETS[request.strength]:
            raise
    return _on_top(_with_id(mesh, request, reserve), mesh, request)


def _authentication_alone(mesh: Mesh, request: MarkRequest) -> str:
    """Return what to add to the refusal of the id where there is room for the marks of authentication."""
    try:
        fits = next(plans(mesh, request.key, request.tolerance), None) is not None
    except CapacityError:
        fits = False
    return "; for --layers authentication, without an id that survives damage, there is room" if fits else ""


def _on_top(below: Owned | None, original: Mesh, request: MarkRequest) -> Embedding:
    """Return the authentication layer, on top of one with the id or alone, read back."""
    if below is None:
        base = Base(original=original, mesh=original, below=None)
    else:
        base = Base(original=original, mesh=below.mesh, below=below.mark)
    upper = with_authentication(base, request)
    displacement = vertex_displacement(original, upper.mesh)
    if displacement.rms > BUDGETS[request.strength] * displacement.diagonal:
        share = displacement_rms(base.mesh, upper.mesh) / displacement.diagonal
        raise _OverBudgetError(share, request.strength)
    ownership, remarks = None, upper.remarks
    if below is not None:
        at_points, telling = parts_read(upper.mesh, request.key, request.id, below.mark.parts)
        ownership = replace(below.mark, carriers=upper.carriers, parts=at_points)
        remarks = (*remarks, *parts_in_words(telling, below.mark.bits))
    return Embedding(
        mesh=upper.mesh,
        id=told_id(request.id),
        strength=request.strength,
        ownership=ownership,
        authentication=upper.mark,
        displacement=displacement,
        remarks=remarks,
    )

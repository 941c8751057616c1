"""The authentication layer of an embedding: planned, written and read back on top of what is there already."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import Enum
from itertools import islice

from meshmark.authentication.examination import examine
from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.planning import Planned, plans
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, without_frames
from meshmark.geometry.surface_of import surface_of
from meshmark.marking.bearing_plan import Borne, bearing, planned_marks
from meshmark.marking.embedding_result import AuthenticationMark
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.parts_telling import with_parts_telling
from meshmark.marking.promises import broken_by
from meshmark.marking.unread_marks import BrokenError, IdLostError, UnplacedError, UnreadError
from meshmark.marking.unseen_words import unseen
from meshmark.marking.verification import authentic
from meshmark.marking.written_marks import Base, Written, write_marks
from meshmark.mesh import Mesh
from meshmark.ownership.extraction import extract, find
from meshmark.ownership.search.search import Search
from meshmark.scene.distinct import as_shown, scene_of

__all__ = ["Authenticated", "with_authentication"]

# Choices of marks that are looked at for each precision, and how many of those that carry the id are made and read
# back. Most choices of a small model leave out a piece of the id.
_CHOICES, _READ = 8, 3
# After this number of choices in a row that take away the id of the layer below no other is expected to leave it.
_LOST = 6
# Choices that are made and read back at most.
_TRIES = 12
# How often marks near points that an examination finds altered by a promised rounding are chosen anew.
_MENDED = 3
# Share of the points below which a remark says how many are in the ring of a mark.
_WATCHED = 0.9


@dataclass(frozen=True, eq=False, kw_only=True)
class Authenticated:
    """A mesh with marks of authentication, and remarks about what was given up for them.

    carriers: from which the id of the layer below is still read; 0 without one.
    """

    mesh: Mesh
    mark: AuthenticationMark
    remarks: tuple[str, ...]
    carriers: int


class _Wanted(Enum):
    """Which marks are tried.

    Marks with payload, that tell the id, or do not, or whether they do or not; or those of small models, which are
    read without the id.
    """

    TELLING_ID = "telling id"
    NOT_TELLING_ID = "not telling id"
    ALL = "all"
    SMALL = "small"

    def has(self, carries_id: bool) -> bool:
        """Return whether marks that carry the id, or do not, are among them."""
        return self in (_Wanted.ALL, _Wanted.SMALL) or carries_id == (self is _Wanted.TELLING_ID)


def with_authentication(base: Base, request: MarkRequest) -> Authenticated:
    """Return the first marks that are read back as they should, and survive what their tolerance promises.

    For each precision a few keyed choices of points are tried, as some leave a point without a voucher. On a layer
    that carries the id, marks that do not tell it are not read once a change has taken it away there. So marks of
    small models, without payload, come before them where nobody asked for a payload.

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
    SeenError
        The request wants marks that are not seen, and words of any length are.
    """
    if _may_go_without_payload(base, request):
        ways: tuple[_Wanted, ...] = (_Wanted.TELLING_ID, _Wanted.SMALL, _Wanted.NOT_TELLING_ID)
    else:
        ways = (_Wanted.ALL if base.has_id else _Wanted.TELLING_ID,)
    refusals: list[CapacityError] = []
    for wanted in ways:
        try:
            return _first_read(base, request, wanted)
        except IdLostError:
            raise
        except CapacityError as error:
            refusals.append(error)
    raise refusals[0]


def _may_go_without_payload(base: Base, request: MarkRequest) -> bool:
    """Return whether marks without payload say all that is asked for: there is nothing else to tell of the file."""
    asked = request.content.kind in ("any", "none")
    return base.has_id and asked and not request.shown and scene_of(base.original) is None


def _first_read(base: Base, request: MarkRequest, wanted: _Wanted) -> Authenticated:
    """Return the first marks of those wanted that hold; raises `CapacityError` where there are none."""
    refusal, lost, tries = (
        CapacityError("no marks of authentication fit, expected more room for payload"),
        0,
        0,
    )
    for planned in plans(base.mesh, request.key, request.tolerance, small=wanted is _Wanted.SMALL):
        chosen = planned
        some = (each for each in _choices(planned, request.key) if wanted.has(each.plan.carries_id))
        refusal = CapacityError("the model has room for too few marks of authentication to tell its id")
        for chosen in islice(some, _READ):
            try:
                return _mended(base, request, chosen, wary=lost > 0)
            except UnreadError as error:
                refusal, tries = without_frames(error), tries + 1
                lost = lost + 1 if isinstance(error, IdLostError) else 0
                if lost == _LOST or tries == _TRIES:
                    raise
            except CapacityError as error:
                refusal = without_frames(error)
                break
        del planned, chosen, some  # the next plan of millions of points takes gigabytes besides
    raise refusal


def _mended(base: Base, request: MarkRequest, chosen: Planned, *, wary: bool) -> Authenticated:
    """Return the marks of a plan, with others where a few do not bear what is promised: that is seen at once."""
    telling = with_parts_telling(base, request, chosen)
    marks = planned_marks(base, request, telling)
    remarks: tuple[str, ...] = ()
    if request.unseen:
        marks, remarks = unseen(base, request, marks)
    made = _with_mended(base, request, bearing(base, request, marks), wary=wary)
    return replace(made, remarks=made.remarks + remarks)


def _with_mended(base: Base, request: MarkRequest, marks: Borne, *, wary: bool) -> Authenticated:
    """Return marks, with others near points where an examination finds that they do not bear what is promised."""
    for _ in range(_MENDED):
        try:
            return _bound_or_not(base, request, marks.written, wary=wary)
        except BrokenError as error:
            known = marks.with_failing(error.broken.passed)
            again = known.mended(base, request, error.broken.unread)
            if again is None:
                raise
            marks = bearing(base, request, again)
    return _bound_or_not(base, request, marks.written, wary=wary)


def _bound_or_not(base: Base, request: MarkRequest, written: Written, *, wary: bool) -> Authenticated:
    """Return marks whose symbols are bound to their places; where these are not found again, marks that are not."""
    if written.bound:
        with suppress(UnplacedError):
            return _read_back(base, request, written, wary=wary)
        written = write_marks(base, request, written.planned, bound=False)
    return _read_back(base, request, written, wary=wary)


def _choices(planned: Planned, key: Key) -> Iterator[Planned]:
    """Yield the plan, then those of other keyed choices of points."""
    yield planned
    surface, precision = planned.plan.surface, planned.precision
    for choice in range(1, _CHOICES):
        yield replace(planned, plan=plan(surface, key, precision.error, choice, precision.style))


def _read_back(base: Base, request: MarkRequest, written: Written, *, wary: bool) -> Authenticated:
    """Return the marks of one plan; raises `CapacityError` where they do not hold.

    wary: other choices took the id below away, so that it is looked for at once.
    """
    result, planned, remarks = written.mesh, written.planned, written.remarks
    precision = planned.precision
    # Marks that do not tell the id have `examine` read the layer below.
    at_once = wary or planned.plan.layout.pieces_only or not planned.plan.carries_id
    if at_once:
        _check_below(base, result, request)
    found = examine(as_shown(result), request.key, made=request.id)
    if written.bound and found.marked and found.payload is None:
        raise UnplacedError("the marks of authentication do not tell where the model lies")
    if not authentic(found, request.id):
        raise UnreadError(
            "the marks of authentication cannot be read back from the positions the file can hold"
        )
    if found.payload != written.payload:
        raise UnreadError("the payload cannot be read back from the marked model")
    broken = broken_by(result, request.key, request.id, precision.bears, precision.error)
    if broken is not None:
        raise BrokenError(broken)
    carriers = 0
    if base.has_id:
        if not at_once:
            _check_below(base, result, request)
        below = extract(result, request.key, search="plain")
        if below.id != request.id:
            raise IdLostError("the id cannot be read beside the marks of authentication")
        carriers = below.carriers
    watched = float(found.checks.verified.sum()) / max(int(found.surface.used.sum()), 1)
    if watched < _WATCHED:
        remarks += (
            f"the marks of authentication watch {100.0 * watched:.0f} % of the points: of the others, whose faces "
            "are slivers or meet in no single fan, a small change may not be seen",
        )
    if precision.remark is not None:
        remarks += (precision.remark,)
    made = AuthenticationMark(
        marks=written.marked.count,
        payload_bytes=len(written.payload.content),
        tolerance=request.tolerance or "default",
    )
    return Authenticated(mesh=result, mark=made, remarks=remarks, carriers=carriers)


def _check_below(base: Base, result: Mesh, request: MarkRequest) -> None:
    """Raise `IdLostError` where the id below is not read even with the lattice known.

    That takes less time than a blind reading, which is done at last.
    """
    below = base.below
    if below is None or below.repeated_only or scene_of(result) is not None:
        return  # where it lies in a scene is found by `extract`
    search = Search(
        surface=surface_of(result),
        key=request.key,
        effort="plain",
        label=below.label,
        spacings=(below.spacing,),
    )
    if find(search).id != request.id:
        raise IdLostError("the id cannot be read beside the marks of authentication")

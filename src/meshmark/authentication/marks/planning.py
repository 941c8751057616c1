"""Which marks are tried on a model, in which order: for the coarsest precision that they can be made for first."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

from meshmark.authentication.marks.plan import Plan, plan
from meshmark.authentication.marks.precision import Precision, precisions_of
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.parameters import FINE, SMALL, SMALL_RINGS
from meshmark.authentication.payload.payload import capacity
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, without_frames
from meshmark.geometry.surface_of import surface_of, surface_of_moved
from meshmark.geometry.together import together
from meshmark.io.file_precision import conform
from meshmark.mesh import Mesh

__all__ = ["Planned", "plans"]

# Marks for a coarser precision are taken where they cover this share of the points, or of what the finer ones do.
_COVERED = 0.9
# Points may become one by rounding where they are nearer than this number of errors of a coordinate: 2 sqrt 3, by
# the errors of both.
_NEAR = 3.5
# Plans of more points than this, a gigabyte each, are made again when it is their turn, not kept until then.
_LARGE = 1_000_000
# Marks that do not hold are made anew for the error times each of these factors.
_COARSER = (1.2, 1.45)


@dataclass(frozen=True, eq=False, kw_only=True)
class Planned:
    """What to mark and how: a mesh of which points that rounding may make one are one already, and its plan.

    content: of the payload, where it was made for nearly the same plan.
    """

    mesh: Mesh
    plan: Plan
    precision: Precision
    content: bytes | None = None


def plans(mesh: Mesh, key: Key, tolerance: str | None, *, small: bool = False) -> Iterator[Planned]:
    """Yield marks, best first: for the coarsest precision that leaves room for what it must, and covers enough.

    Each again made a little coarser, where the first did not hold or bear what they should; then those for finer
    precisions. small: marks without payload, of which few are enough. Raises `CapacityError` where there are none.
    """
    precisions = precisions_of(mesh, tolerance)
    if small:
        precisions = tuple(
            replace(each, style=SMALL, enough=0.0) for each in precisions if each.style is FINE
        )
        rings = sum(len(group.vertex) for group in rings_of(surface_of(mesh)))
        if rings > SMALL_RINGS:
            raise CapacityError(
                f"marks of authentication without payload are for {SMALL_RINGS} points at most"
            )
    for first in _by_precision(mesh, key, precisions):
        precision = first.precision
        yield first
        del first  # one plan of millions of points is enough at a time
        for more in _COARSER:
            with suppress(CapacityError):
                yield _planned(mesh, key, replace(precision, error=more * precision.error))


@dataclass(frozen=True, eq=False, kw_only=True)
class _Waiting:
    """A plan that may be wanted later: its precision, what share of the points it covers, and itself if kept."""

    precision: Precision
    covered: float
    kept: Planned | None

    def planned(self, mesh: Mesh, key: Key) -> Planned:
        """Return the plan, made again where it was not kept."""
        return self.kept or _planned(mesh, key, self.precision)


def _by_precision(mesh: Mesh, key: Key, precisions: tuple[Precision, ...]) -> Iterator[Planned]:
    waiting: list[_Waiting] = []
    refusal = CapacityError("no marks of authentication fit, expected more room for payload")
    enough = False
    for precision in precisions:
        try:
            found = _looked_at(mesh, key, precision, wanted=enough)
        except CapacityError as error:
            refusal = without_frames(error)
            continue
        if found is not None:
            enough = enough or found.covered >= _COVERED
            waiting.append(found)
            found = None
        if enough:
            yield from _covering(mesh, key, waiting)
    if not (waiting or enough):
        raise refusal
    yield from _covering(mesh, key, waiting)


def _looked_at(mesh: Mesh, key: Key, precision: Precision, *, wanted: bool) -> _Waiting | None:
    """Return the plan of a precision, None where it has too little room.

    It is kept where it is `wanted` whatever it covers, covers enough, or is small.
    """
    found = _planned(mesh, key, precision)
    points = len(found.plan.surface.points)
    if 8 * capacity(found.plan.payload_marks, found.plan.symbol_bits) < precision.enough * points:
        return None
    kept = wanted or found.plan.covered >= _COVERED or points <= _LARGE
    return _Waiting(precision=precision, covered=found.plan.covered, kept=found if kept else None)


def _covering(mesh: Mesh, key: Key, waiting: list[_Waiting]) -> Iterator[Planned]:
    """Yield those that cover nearly as much of the points as the best of them."""
    least = _COVERED * max((each.covered for each in waiting), default=0.0)
    left = [each for each in waiting if each.covered >= least]
    waiting.clear()
    while left:
        yield left.pop(0).planned(mesh, key)  # and nobody here keeps it


def _planned(mesh: Mesh, key: Key, precision: Precision) -> Planned:
    surface, before = surface_of(mesh), mesh
    placed = together(surface.points, _NEAR * precision.error)
    if (placed != surface.points).any():
        mesh = mesh.with_vertices(conform(mesh, placed[surface.point_of_vertex]))
        surface = surface_of_moved(mesh, before)
    return Planned(
        mesh=mesh, plan=plan(surface, key, precision.error, style=precision.style), precision=precision
    )

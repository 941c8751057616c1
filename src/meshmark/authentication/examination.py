"""What authentication and recovery both start from: the marks of a suspect, its altered points and its payload."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.as_written import Since, since_written
from meshmark.authentication.checks.altered_points import altered_points
from meshmark.authentication.checks.carried import Expected, Reading
from meshmark.authentication.checks.checks import Checks, check, shapes_of
from meshmark.authentication.checks.coarse_digits import coarse_digits
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.parameters import MARKED_LOG10
from meshmark.authentication.payload.payload import Payload, decode, unpack
from meshmark.authentication.payload.signed_totals import Whole, points_distinct, points_shown, unmarked_parts
from meshmark.certificate.binding import mismatch, refuse_edited
from meshmark.certificate.certificate import Certificate
from meshmark.coding.erasure.erasure_code import ErasureCode
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, PRESENCE, bits_of
from meshmark.geometry.shown import Shown, times_of
from meshmark.geometry.surface import Surface
from meshmark.mesh import Mesh
from meshmark.ownership.extraction import extract
from meshmark.ownership.extraction_result import Extraction
from meshmark.scene.surfaces import marked_surface, mirrored, unfolded

__all__ = ["DOUBTFUL_LOG10", "Examination", "examine"]

DOUBTFUL_LOG10 = -4.0
"""Between this and `MARKED_LOG10` nothing is said."""
# Area is missing where it is off by more than this number of deviations of the scale.
_SURE = 3.0
# Points that a grid of 14 bits may make one.
_MERGED = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Examination:
    """surface: the suspect's; checks: of its marks; id: the model's, from the marks or from the ownership layer,
    `PRESENCE` of a mark that carries none, or None. marked: marks of authentication hold. altered: (p,) points,
    all of them where no mark holds.
    log10_false_positive: bound on the chance of the marks, or else of the id, without the key. payload: what the
    intact part carries, None where it is too little.
    rounded: what coordinates were rounded to, where there is an id and no mark bears such a rounding.
    Where there is an id but no mark, ownership_only: the certificate says that there never was one; since: what is
    known of the model since it was written, by its certificate alone.
    remark: a sentence where the certificate is not this model's; nothing was taken from it then.
    present: without marks, the layer of the id is there, whether an id is told or not; ids: those of several copies
    that it tells, which were put together.
    """

    surface: Surface
    checks: Checks
    id: int | None
    marked: bool
    altered: NDArray[np.bool_]
    log10_false_positive: float
    payload: Payload | None = None
    ownership_only: bool = False
    since: Since = Since.UNKNOWN
    rounded: str | None = None
    remark: str | None = None
    present: bool = False
    ids: tuple[int, ...] = ()

    @property
    def points_missing(self) -> int | None:
        """How many points fewer there are than were signed off, below 0 where there are more; None: not known."""
        if self.payload is None or not self.payload.whole.points:
            return None
        whole = self.payload.whole
        missing = whole.points - points_shown(self.surface)
        if missing == 0 and whole.distinct and isinstance(self.surface, Shown):
            missing = whole.distinct - points_distinct(self.surface)
        return 0 if self.checks.requantised and abs(missing) <= _MERGED else missing

    @cached_property
    def area_missing(self) -> float | None:
        """Which share of the surface that was signed off is gone, 0 to 1; None where it is not known."""
        scale = self.checks.scale
        if self.payload is None or not self.payload.whole.area or not scale.half:
            return None
        areas = self.surface.point_areas * times_of(self.surface)
        left = float(areas[~unmarked_parts(self.surface, self.checks.verified)].sum())
        share = 1.0 - left / (self.payload.whole.area * scale.half**2)
        return share if share > _SURE * 2.0 * scale.doubt else 0.0


def examine(
    mesh: Mesh, key: Key, reference: Certificate | Mesh | None = None, *, made: int | None = None
) -> Examination:
    """Look for the marks of a mesh; where they do not report the model's id, the ownership layer is read.

    Copies of one mesh that only their shape shows are looked for where the model is not intact without, and
    believed where the marks say that it had some.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
    reference : Certificate or Mesh, optional
        Helps to find the ownership layer.
    made : int, optional
        Id of marks that were just made. Where they do not hold with it, the ownership layer, which takes long to
        read, can tell nothing else; and what are copies, the model's file says.

    Returns
    -------
    Examination

    Raises
    ------
    InputError
        The mesh has no surface, or the certificate of this key was edited.
    """
    if isinstance(reference, Certificate):
        refuse_edited(reference, key)
    effort = "plain" if reference is None else "quick"
    ask = cache(
        lambda: extract(mesh, key, reference=reference, search=effort, cut=made is None, copies=made is None)
    )
    found = _examined(mesh, marked_surface(mesh), key, reference, ask, made=made)
    if made is not None or isinstance(found.surface, Shown) or _intact(found):
        return found
    if found.payload and not found.payload.whole.distinct:
        return found
    from meshmark.scene.copies_by_shape import repeated

    for copies in repeated(mesh, cut=True):
        surface = unfolded(mesh, copies)
        for way in (surface, *mirrored(surface)):
            if _intact(found):
                return found
            again = _examined(mesh, way, key, reference, ask)
            if again.payload is not None and again.payload.whole.distinct and _less(again, found):
                found = again
    return found


def _intact(found: Examination) -> bool:
    return found.marked and not (found.altered.any() or found.points_missing)


def _less(one: Examination, other: Examination) -> bool:
    """Return whether less of one is altered than of another examination of the same model."""
    if one.marked != other.marked:
        return one.marked
    return (int(one.altered.sum()), abs(one.points_missing or 0)) < (
        int(other.altered.sum()),
        abs(other.points_missing or 0),
    )


def _examined(
    mesh: Mesh,
    surface: Surface,
    key: Key,
    reference: Certificate | Mesh | None,
    ask: Callable[[], Extraction],
    *,
    made: int | None = None,
) -> Examination:
    """Examine one surface of a mesh; ask: reads the ownership layer; made: see `examine`."""
    look = partial(check, surface, key, shapes=shapes_of(surface))
    checks = look()
    identity = checks.nonce
    if identity is None or checks.log10_chance > MARKED_LOG10:
        expected = None if made is None else look(made)
        if expected is not None and expected.log10_chance > MARKED_LOG10:
            return _unmarked(surface, checks)
        found = ask()
        identity = PRESENCE if found.bits == 0 else found.id
        if identity is not None and bits_of(identity) == ID_BITS:  # others sign no marks
            again = expected if identity == made else None
            checks = look(identity) if again is None else again
    certificate = reference if isinstance(reference, Certificate) else None
    remark = None if certificate is None else mismatch(certificate, key, identity)
    if checks.speak and checks.log10_chance <= MARKED_LOG10:
        packed = None
        if identity is not None and bits_of(identity) == ID_BITS:
            packed, reading = _packed(checks, key, identity)
            if packed is not None:
                checks = _confirmed(surface, checks, packed, reading, look)
        altered, payload = altered_points(surface, checks), None if packed is None else unpack(packed)
        if checks.signed is not None:
            payload = Payload(kind="none", content=b"", whole=Whole(points=checks.signed))
        known = Examination(
            surface=surface,
            checks=checks,
            id=identity,
            marked=True,
            altered=altered,
            log10_false_positive=checks.log10_chance,
            payload=payload,
            remark=remark,
        )
        if (known.points_missing or 0) < 0:  # parts were added on which there are no marks to fail
            altered |= unmarked_parts(surface, checks.verified)
        return known
    present = found.presence == "present"
    own = certificate if identity is not None and remark is None else None
    layers = None if own is None else own.more.get("layers")
    since = Since.UNKNOWN
    if own is not None and layers == "ownership":
        since = since_written(own, mesh, key)
    rounded = None if identity is None or layers == "ownership" else _rounded(mesh)
    if layers == "both" and rounded is None:
        since = Since.CHANGED
    return replace(
        _unmarked(surface, checks),
        id=identity,
        log10_false_positive=found.log10_false_positive if present else checks.log10_chance,
        ownership_only=layers == "ownership",
        since=since,
        rounded=rounded,
        remark=remark,
        present=present,
        ids=found.ids if identity is None else (),
    )


def _unmarked(surface: Surface, checks: Checks) -> Examination:
    """Return that neither marks nor an id are there."""
    return Examination(
        surface=surface,
        checks=checks,
        id=None,
        marked=False,
        altered=np.ones(len(surface.points), bool),
        log10_false_positive=checks.log10_chance,
    )


def _rounded(mesh: Mesh) -> str | None:
    """Return what coordinates were rounded to, more coarsely than a file needs to be."""
    coarse = coarse_digits(mesh.vertices)
    return None if coarse is None or coarse.half <= precision_of(mesh) else coarse.called


def _packed(checks: Checks, key: Key, identity: int) -> tuple[bytes | None, Reading]:
    """Return what the believed marks carry, else what all that hold do: scattered ones prove each other so.

    And how they were read: by the cells of the model where it is known where it lies, else, as marks of small
    models are, without.
    """
    reading = Reading(key=key, nonce=identity, symbol_bits=checks.symbol_bits, frame=None)
    for frame in dict.fromkeys((checks.frame, None)):
        reading = replace(reading, frame=frame)
        for marks in (checks.carried, checks.carried.take(checks.carried.plain), checks.held):
            index, value = reading.sure(marks)
            packed = decode(index, value, checks.symbol_bits) if len(index) else None
            if packed is not None:
                return packed, reading
    return None, reading


def _confirmed(
    surface: Surface, checks: Checks, packed: bytes, reading: Reading, look: Callable[..., Checks]
) -> Checks:
    """Return the checks anew where a point is altered, or has no other voucher than marks against the payload.

    A mark that was put at random, was copied to another place, or holds by luck, says the symbol that the payload
    has there once in 2^9 or so. In a rounded file one such mark can hide that its neighbour is to be read in
    another way, or dispute where a component lies: so nothing is called altered by a check that does not know the
    payload. look: `check` of this surface.
    """
    source, once = ErasureCode(packed, checks.symbol_bits), unpack(packed).whole.once
    expected = Expected(source=source, reading=reading, frame=checks.frame, once=once)
    held = checks.held.vertex
    right = expected.agrees(checks.held)
    passed = checks.passed.copy()
    passed[held[~right]] = False
    passed[held[right]] = checks.passed[held[right]]
    again = partial(look, reading.nonce, expected)
    if altered_points(surface, checks).any() or (once and checks.repeated):
        return again()
    if (passed == checks.passed).all():
        return checks
    vouched = passed | (surface.graph @ passed.astype(np.float64) > 0.0)
    if not (checks.eligible & checks.verified & ~vouched).any():
        return checks
    return again()

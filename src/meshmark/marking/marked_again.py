"""The marked copy made again from the original: by what its marks and certificate say, and by what fits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from meshmark.authentication.examination import Examination
from meshmark.authentication.payload.content import Content
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, bits_of
from meshmark.errors import CapacityError
from meshmark.marking.both_layers import embed_for
from meshmark.marking.mark_request import MarkRequest
from meshmark.mesh import Mesh
from meshmark.recovery.whole_placement import PlacedWhole
from meshmark.strengths import BUDGETS

__all__ = ["MarkedAgain", "marked_again"]

# A copy made again is the one that was marked where this share of the intact points lie in their places; of copies
# that come less near the best is taken, if it has this share: some of what marks call intact may have been moved
# where they do not watch, and without marks nothing is known to be intact.
_SURE, _LEAST, _LEAST_UNMARKED = 0.98, 0.9, 0.5


@dataclass(frozen=True, kw_only=True)
class _Settings:
    """Options of `embed`."""

    strength: str
    layers: str | None
    payload: Content
    tolerance: str | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class MarkedAgain:
    """A marked copy as made again, and how it lies in the suspect."""

    mesh: Mesh
    placed: PlacedWhole


def marked_again(
    original: Mesh,
    key: Key,
    found: Examination,
    certificate: Certificate | None,
    place: Callable[[Mesh], PlacedWhole | None],
) -> MarkedAgain | None:
    """Return the marked copy that the suspect was made from, made again from the original.

    Parameters
    ----------
    original : Mesh
    key : Key
    found : Examination
        Of the suspect; its id is known.
    certificate : Certificate, optional
        Of the marked copy; it tells strength and layers, which are tried one after another without it.
    place : callable
        Places a copy in the suspect; None where it does not fit.

    Returns
    -------
    MarkedAgain or None
        None where no setting gives a copy whose points lie where the suspect's intact ones do.
    """
    best: MarkedAgain | None = None
    kept: _Settings | None = None
    for choices in (_strengths, _tolerances, _payloads):
        for settings in choices(kept, found, certificate):
            made = _made(original, key, found, settings)
            placed = None if made is None else place(made)
            if made is None or placed is None:
                continue
            if best is None or placed.share > best.placed.share:
                best, kept = MarkedAgain(mesh=made, placed=placed), settings
            if placed.share >= _SURE:
                return best
    least = _LEAST if found.marked else _LEAST_UNMARKED
    return best if best is not None and best.placed.share >= least else None


def _strengths(
    _: _Settings | None, found: Examination, certificate: Certificate | None
) -> Iterator[_Settings]:
    payload: Content = None
    if found.payload is not None and found.payload.kind in ("bytes", "image"):
        payload = found.payload.content
    strengths = sorted(BUDGETS, key=lambda name: name != "standard")
    layers: list[str | None] = [None, "authentication"] if found.marked else ["ownership", None]
    if certificate is not None:
        strengths = [certificate.strength]
        layers = [None if (named := certificate.more.get("layers")) == "both" else str(named)]
    if found.id is not None and bits_of(found.id) != ID_BITS:
        layers = ["ownership"]  # others sign no marks
    for each in layers:
        for strength in strengths:
            asked = None if each == "ownership" else payload
            yield _Settings(strength=strength, layers=each, payload=asked)


def _tolerances(kept: _Settings | None, *_: object) -> Iterator[_Settings]:
    if kept is None or kept.layers == "ownership":
        return
    for tolerance in ("web", "default", "tolerant", "strict"):
        yield replace(kept, tolerance=tolerance)


def _payloads(kept: _Settings | None, found: Examination, *_: object) -> Iterator[_Settings]:
    if kept is None or kept.layers == "ownership" or kept.payload is not None:
        return
    if found.payload is None or found.payload.kind == "none":
        yield replace(kept, payload="none")


def _made(original: Mesh, key: Key, found: Examination, settings: _Settings) -> Mesh | None:
    request = MarkRequest.checked(
        key,
        id=found.id,
        bits=ID_BITS if found.id is None else bits_of(found.id),
        strength=settings.strength,
        layers=settings.layers,
        payload=settings.payload,
        tolerance=settings.tolerance,
    )
    goes_to = None if original.document is None else original.document.format  # most copies keep it
    try:
        return embed_for(original, request, goes_to).mesh
    except CapacityError:
        return None

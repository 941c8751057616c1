"""What is checked before a marked model is handed on: `authenticate` and `extract` say of it what they should."""

from __future__ import annotations

from meshmark.authentication.checks.checks import check
from meshmark.authentication.checks.setting_search import any_hold
from meshmark.authentication.examination import Examination, examine
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.parameters import MARKED_LOG10
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, bits_of
from meshmark.errors import CapacityError
from meshmark.marking.embedding_result import Embedding
from meshmark.mesh import Mesh
from meshmark.ownership.extraction import extract
from meshmark.scene.surfaces import marked_surface

__all__ = ["authentic", "verify"]


def verify(
    mesh: Mesh,
    key: Key,
    expected: Embedding,
    where: str = "the marked model",
    *,
    compressed: bool = False,
) -> None:
    """Check that a mesh is authentic by its marks and carries the id, with the key alone.

    Of a model with the id alone there must be no marks that would call it altered. expected: what was embedded;
    where: name of what holds the mesh; compressed: it was compressed on request.
    Raises `CapacityError` with a sentence about the layer that fails.
    """
    if compressed:
        coarse = f"cannot be read back from {where} once it is compressed"
        advice = ("leave --recompress out", "use --tolerance tolerant, or leave --recompress out")
    else:
        coarse = f"cannot be read back from {where}, whose format holds positions too coarsely"
        same_format = "or the format of the input"
        advice = (f"use --strength strong {same_format}", f"use --tolerance tolerant {same_format}")
    if expected.layers == "ownership":
        read = extract(mesh, key, search="plain")
        identity, bits = read.id, read.bits
        if _has_marks(mesh, key, expected.id):
            raise CapacityError(
                "the model carries authentication marks of this key already, and beside a new id they would call "
                "it altered; mark the unmarked original, or with --layers both"
            )
    else:
        found = examine(mesh, key)
        if not authentic(found, expected.id):
            raise CapacityError(f"the marks of authentication {coarse}; {advice[1]}")
        identity, bits = extract(mesh, key).id if expected.layers == "both" else found.id, expected.bits
    if (identity, bits) != (expected.id, expected.bits):
        raise CapacityError(f"the {'id' if expected.bits else 'mark'} {coarse}; {advice[0]}")


def _has_marks(mesh: Mesh, key: Key, identity: int | None) -> bool:
    """Return whether a mesh has marks of authentication, of this id or of the one that they tell.

    All rings are read only where those of a sample hold more often than by luck, under any step and layout: most
    meshes have no marks.
    """
    surface = marked_surface(mesh)
    signed = identity is not None and bits_of(identity) == ID_BITS
    own = identity if signed else None
    for nonce, may in zip((None, own), any_hold(surface.points, rings_of(surface), key, own), strict=True):
        if may:
            found = check(surface, key, nonce)
            if found.speak and found.log10_chance <= MARKED_LOG10:
                return True
    return False


def authentic(found: Examination, identity: int | None) -> bool:
    """Return whether `authenticate` calls a model authentic by its marks, with this id."""
    intact = found.marked and not found.altered.any() and not found.points_missing
    return intact and identity is not None and found.id == identity

"""Which mark of fewer bits a model would carry that cannot carry the one that was asked for."""

from __future__ import annotations

from contextlib import suppress

from meshmark.coding.message import BITS, requested_id
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.repeated_mesh import embed_repeated
from meshmark.mesh import Mesh

__all__ = ["fewer_bits_that_fit"]

# Larger models are not tried: that takes as long as marking them.
_SMALL = 5_000


def fewer_bits_that_fit(mesh: Mesh, request: MarkRequest) -> str:
    """Return what to add to a refusal: the most bits, fewer than were asked for, that were tried and fit.

    Empty where none do, or the model is too large to try.
    """
    if len(surface_of(mesh).points) > _SMALL:
        return ""
    for bits in BITS:
        if bits < request.bits:
            # The last digits of the id that was asked for: the same request is told the same.
            shorter = requested_id(request.id % (1 << bits) if bits else None, bits)
            with suppress(CapacityError):
                embed_repeated(mesh, request.key, id=shorter, strength=request.strength)
                carried = (
                    f"an id of {bits} bits" if bits else "a mark without an id, which says that it is there"
                )
                return f"; --bits {bits} fits, {carried}"
    return ""

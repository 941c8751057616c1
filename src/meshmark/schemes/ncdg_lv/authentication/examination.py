"""What authentication and recovery both start from: the marks of a suspect, its altered points and its payload."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keys import Key
from meshmark.geometry.weld import Welded, weld
from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.authentication.checks import Checks, check
from meshmark.schemes.ncdg_lv.authentication.localisation import altered_points
from meshmark.schemes.ncdg_lv.authentication.payload import Payload, decode, unpack
from meshmark.schemes.ncdg_lv.certificate import Certificate
from meshmark.schemes.ncdg_lv.extraction import extract

__all__ = ["DOUBTFUL_LOG10", "MARKED_LOG10", "Examination", "examine"]

MARKED_LOG10 = -9.0
"""Marks are there where so many hold by chance less often than this."""
DOUBTFUL_LOG10 = -4.0
"""Between the two nothing is said."""


@dataclass(frozen=True, eq=False)
class Examination:
    """surface: the suspect's; checks: of its marks; id: the model's, from the marks or from the ownership layer, or
    None. marked: marks of authentication hold. altered: (p,) points, all of them where no mark holds.
    log10_false_positive: bound on the chance of the marks, or else of the id, without the key.
    """

    surface: Welded
    checks: Checks
    id: int | None
    marked: bool
    altered: NDArray[np.bool_]
    log10_false_positive: float

    @cached_property
    def payload(self) -> Payload | None:
        """What the intact part carries, None where it is too little."""
        checks = self.checks
        if not self.marked or not len(checks.index):
            return None
        packed = decode(checks.index, checks.value, checks.symbol_bits)
        return None if packed is None else unpack(packed)


def examine(mesh: Mesh, key: Key, reference: Certificate | Mesh | None = None) -> Examination:
    """Look for the marks of a mesh; where they do not tell the model's id, the ownership layer is asked.

    reference: helps to find the ownership layer. Raises `InputError` where the mesh has no surface.
    """
    surface = weld(mesh)
    checks = check(surface, key)
    if checks.nonce is not None and checks.log10_chance <= MARKED_LOG10:
        altered = altered_points(surface, checks)
        return Examination(surface, checks, checks.nonce, True, altered, checks.log10_chance)
    found = extract(mesh, key, reference=reference, locking=reference is not None)
    if found.id is not None:
        again = check(surface, key, found.id)
        if again.log10_chance <= MARKED_LOG10:
            altered = altered_points(surface, again)
            return Examination(surface, again, found.id, True, altered, again.log10_chance)
        checks = again
    everything = np.ones(len(surface.points), bool)
    bound = found.log10_false_positive if found.id is not None else checks.log10_chance
    return Examination(surface, checks, found.id, False, everything, bound)

"""What the coordinates of a fingerprint say: pilots a 0, most a bit of the id's word, witnesses what checks the id.

Words add up: where three copies a + b - c are put together each coordinate says the sum of three bits, and the sum
of three words is the word of an id that nobody has. What witnesses say of an id is a keyed hash of it, which does
not add up, so that they contradict such an id (docs/decisions/0038-two-averaged-copies.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.fingerprint.parameters import PILOTS, WITNESSES
from meshmark.ownership.points.point_lattice import PointKeys, PointLattice

__all__ = ["Said", "are_pilots", "are_witnesses", "fingerprint_lattice"]

# The role of a coordinate comes from the digits of its draw beyond these bits: a share of 1 draws them all.
_BEYOND = 2.0**20


def fingerprint_lattice(key: Key, label: Label) -> PointLattice:
    """Return the cubes of the fingerprint under a label; they have nothing in common with those of other marks."""
    return PointLattice.keyed(key, label, "fingerprint")


def are_pilots(draw: FloatArray) -> NDArray[np.bool_]:
    """Return which coordinates, by their draws (any shape), are pilots."""
    return np.asarray(_role(draw) < PILOTS)


def are_witnesses(draw: FloatArray) -> NDArray[np.bool_]:
    """Return which coordinates, by their draws (any shape), are witnesses."""
    role = _role(draw)
    return np.asarray((role >= PILOTS) & (role < PILOTS + WITNESSES))


def _role(draw: FloatArray) -> FloatArray:
    digits = draw * _BEYOND
    return np.asarray(digits - np.floor(digits))


@dataclass(frozen=True, eq=False)
class Said:
    """What the coordinates say of an id. word, witness: (LENGTH,) bits of its code word, and of its hash."""

    word: Bits
    witness: Bits

    @classmethod
    def of(cls, codec: Codec, identity: int) -> Said:
        """Return what they say of an id of 64 bits."""
        return cls(codec.encode(identity), codec.witness(identity))

    def bits(self, keys: PointKeys) -> Bits:
        """Return the bits (n, 3) of coordinates."""
        said = np.where(are_witnesses(keys.draw), self.witness[keys.code_index], self.word[keys.code_index])
        return np.where(are_pilots(keys.draw), 0, said).astype(np.uint8)

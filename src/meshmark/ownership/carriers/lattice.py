"""The keyed lattice: which places of canonical space are carriers, and what each one asks of its bit.

A cell is a lattice node with a compact window around it. Everything about a cell comes from its integer
coordinates and the key, so cells need no order and a lost cell is only an erasure (docs/design.md, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import offset, rotation, unit_interval
from meshmark.coding.keyed_code import LENGTH
from meshmark.coding.keys import Key
from meshmark.coding.known_words import KnownWords
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lattice_label import Label

__all__ = ["CellKeys", "Lattice"]

# Share of the cells that are pilots, and what a doubled phase counts in the lock beside a pilot's single one.
PILOTS = 0.2
DOUBLED = 0.35


@dataclass(frozen=True, eq=False, kw_only=True)
class CellKeys:
    """What the key says of n cells.

    code_index: (n,) which code bit the cell carries; dither: (n,) in [0, 1), in quantisation steps; pilot: (n,)
    True for cells whose bit is 0 whatever the id: they carry none of it, and show where the lattice lies.
    """

    code_index: IntArray
    dither: FloatArray
    pilot: NDArray[np.bool_]

    @property
    def factor(self) -> FloatArray:
        """Return what phases (n,) are multiplied by so that they do not depend on bits: 1 for pilots, else 2."""
        return np.where(self.pilot, 1.0, 2.0)

    @property
    def weight(self) -> FloatArray:
        """Return how much each cell counts in the lock (n,), squares of mean 1: doubled phases tell less."""
        weight = np.where(self.pilot, 1.0, DOUBLED)
        return np.asarray(weight / np.sqrt(np.mean(weight**2))) if len(weight) else weight


@dataclass(frozen=True, eq=False, kw_only=True)
class Lattice:
    """A cubic lattice in canonical space, turned and shifted by the key.

    spacing: distance of neighbouring nodes, in units of the canonical frame's scale.
    axes:    (3, 3) rows are the lattice directions; shift: (3,) in spacings.
    """

    spacing: float
    label: Label
    axes: FloatArray
    shift: FloatArray
    _words: KnownWords

    @classmethod
    def keyed(cls, key: Key, spacing: float, label: Label) -> Lattice:
        """The lattice of this spacing and label under `key`.

        Each spacing has a shift and cells of its own, each label a turn as well: lattices of two labels have
        nothing in common.
        """
        purpose = f"lattice {spacing:.6f} of {label}"
        return cls(
            spacing=spacing,
            label=label,
            axes=rotation(key.subkey(f"lattice turn of {label}")),
            shift=offset(key.subkey(purpose)),
            _words=KnownWords(key.subkey(purpose + " cells"), 3),
        )

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Canonical coordinates (p, 3) -> lattice coordinates (p, 3), nodes at the integers."""
        return points @ (self.axes.T / self.spacing) + self.shift

    def points(self, coordinates: FloatArray) -> FloatArray:
        """Lattice coordinates (p, 3) -> canonical coordinates (p, 3)."""
        return (coordinates - self.shift) @ (self.axes * self.spacing)

    def keys(self, nodes: IntArray) -> CellKeys:
        """What the key says of the cells at integer coordinates (n, 3)."""
        words = self._words.of(nodes)
        return CellKeys(
            code_index=(words[:, 0] % np.uint64(LENGTH)).astype(np.int64),
            dither=unit_interval(words[:, 1]),
            pilot=unit_interval(words[:, 2]) < PILOTS,
        )

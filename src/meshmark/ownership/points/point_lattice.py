"""What the key says of a point, by the cube of canonical space that it lies in: which code bits it carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.coding.keyed import offset, rotation, unit_interval
from meshmark.coding.keyed_code import LENGTH
from meshmark.coding.keys import Key
from meshmark.coding.known_words import KnownWords
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.points.parameters import SIDE

__all__ = ["PointKeys", "PointLattice", "distinct_cubes"]

# Bits of a code index: three fit into one word.
_INDEX_BITS = 16
# Cubes in the box around some are numbered up to this.
_NAMES = 2.0**62
# And listed in a table where there are at most this number of times as many.
_TABLE = 64


def distinct_cubes(cubes: IntArray) -> tuple[IntArray, IntArray]:
    """Return the different ones (k, 3) of some cubes (n, 3), and which of them (n,) each is."""
    if not len(cubes):
        return cubes, np.zeros(0, np.int64)
    places = np.ascontiguousarray(cubes.T)
    low = places.min(axis=1)
    size = places.max(axis=1) - low + 1
    box = float(np.prod(size.astype(np.float64)))
    if box > _NAMES:
        different, row = np.unique(cubes, axis=0, return_inverse=True)
        return different, row.ravel()
    x, y, z = places - low[:, None]
    name = (x * size[1] + y) * size[2] + z
    if box > _TABLE * len(cubes):
        names, row = np.unique(name, return_inverse=True)
    else:  # by a table of all cubes in the box about them: many times faster
        there = np.zeros(int(box), bool)
        there[name] = True
        names = np.flatnonzero(there)
        number = np.empty(len(there), np.int64)
        number[names] = np.arange(len(names))
        row = number[name]
    return np.stack(np.unravel_index(names, tuple(size)), axis=1) + low, row.ravel()


@dataclass(frozen=True, eq=False, kw_only=True)
class PointKeys:
    """What the key says of the coordinates of n points.

    cube: (n,) equal for points in one cube, of which it says the same. code_index: (n, 3) which code bit each
    carries; dither: (n, 3) in [0, 1), in steps; draw: (n, 3) in [0, 1): coordinates below the share that carries
    do; first: (n,) 0, 1 or 2, the coordinate that is preferred where several move as cheaply.
    """

    cube: IntArray
    code_index: IntArray
    dither: FloatArray
    draw: FloatArray
    first: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class PointLattice:
    """Cubes of side `SIDE` in canonical space, turned (3, 3) and shifted (3,) by the key and a label."""

    label: Label
    axes: FloatArray
    shift: FloatArray
    _words: KnownWords

    @classmethod
    def keyed(cls, key: Key, label: Label, use: str = "points") -> PointLattice:
        """Return the lattice of a label: those of two labels, or of two uses, have nothing in common."""
        return cls(
            label=label,
            axes=rotation(key.subkey(f"turn of {use} of {label}")),
            shift=offset(key.subkey(f"shift of {use} of {label}")),
            _words=KnownWords(key.subkey(f"{use} of {label}"), 7),
        )

    def places(self, canonical: FloatArray) -> FloatArray:
        """Return where canonical points (n, 3) lie, in sides of the cubes."""
        return canonical @ (self.axes.T / SIDE) + self.shift

    def cubes(self, canonical: FloatArray) -> IntArray:
        """Return the integer coordinates (n, 3) of the cubes that canonical points lie in."""
        return np.floor(self.places(canonical)).astype(np.int64)

    def keys(self, cubes: IntArray) -> PointKeys:
        """Return what the key says of points in these cubes (n, 3)."""
        different, row = distinct_cubes(cubes)
        words = self._words.of(different)
        shifts = np.arange(3, dtype=np.uint64) * np.uint64(_INDEX_BITS)
        indices = (words[:, :1] >> shifts) & np.uint64(2**_INDEX_BITS - 1)
        return PointKeys(
            cube=row,
            code_index=(indices % np.uint64(LENGTH)).astype(np.int64)[row],
            dither=unit_interval(words[:, 1:4])[row],
            draw=unit_interval(words[:, 4:7])[row],
            first=((words[:, 0] >> np.uint64(3 * _INDEX_BITS)) % np.uint64(3)).astype(np.int64)[row],
        )

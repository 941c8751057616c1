"""Ways to read rings: the neighbour that leads and the rounding of the lengths, with the keyed numbers of each.

Where a length lies near a rounding boundary, or two neighbours are about equally far, a file of little precision
may turn the one into the other. Each such reading is a way.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray
from meshmark.authentication.marks.ring_shapes import RingShapes, starts
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.parameters import AMBIGUOUS, HASH_STEP, HASH_STEPS
from meshmark.coding.keyed import cell_words
from meshmark.mesh import FloatArray, IntArray

__all__ = ["HEADER", "PAYLOAD", "PLACE", "WORDS", "Hash", "Ways", "lengths", "step_of", "tolerances", "ways"]

HEADER, PLACE, PAYLOAD = 0, 1, 2
"""What the symbol of a mark is: a piece of the model's id, the mark's place, or a symbol of the payload."""
WORDS: Final = 7
"""Number of a ring's keyed numbers."""
# Number of marks in 32 that carry the id, and that carry their place.
_HEADERS: Final = 3
_PLACES: Final = 4
# Lengths such as 1 and 2, which regular rings have, must not lie on a rounding boundary.
_SHIFT: Final = 0.381966


@dataclass(frozen=True, eq=False, kw_only=True)
class Ways:
    """c ways to read some of r rings.

    rings, shapes: the rings. row: (c,) which of them; order: (c, k) the neighbours, that which leads first. level:
    (c,) of the step. words: (c, 7) uint64, the ring's keyed numbers. kind: (c,) HEADER, PLACE or PAYLOAD.
    """

    rings: Rings = field(repr=False)
    shapes: RingShapes = field(repr=False)
    row: NDArray[np.int32]
    order: NDArray[np.int8]
    level: NDArray[np.int16]
    words: NDArray[np.uint64]
    kind: NDArray[np.int8]

    def of_kind(self, kind: int) -> Ways:
        """Return those of a kind."""
        kept = np.flatnonzero(self.kind == kind)
        names = ("row", "order", "level", "words", "kind")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})


class Hash(Protocol):
    """What gives rings their keyed numbers."""

    def __call__(self, read: IntArray, cell: FloatArray) -> NDArray[np.uint64]:
        """Return the numbers (n, WORDS) of rings as they were read (n, 2 + 2k), lengths in units `cell` (n,)."""


def step_of(level: AnyIntArray) -> FloatArray:
    """Return the steps (r,) of levels, in units of the ring size."""
    return np.asarray(2.0 ** (-np.asarray(level, np.float64) / 2.0))


def ways(
    rings: Rings, shapes: RingShapes, rows: IntArray, level: IntArray, subkey: bytes | Hash, *, all_ways: bool
) -> Ways:
    """Return the ways to read the rings `rows` (n,) with these levels (n,): the plain one of each, or all.

    subkey: from which the keyed numbers follow, or, of the plain ways, what gives those of all rows in their order.
    """
    every = len(rows) == len(shapes.size) and bool((rows == np.arange(len(rows))).all())
    some = shapes if every else shapes.take(rows)  # a copy of each array, where it is needed
    tolerance = tolerances(some, level)
    row, first = starts(some.distance, tolerance if all_ways else np.zeros(len(rows)))
    if not all_ways:
        row, unique = np.unique(row, return_index=True)
        first = first[unique]
    size = rings.around.shape[1]
    order = (first[:, None] + np.arange(size)) % size
    values, cell = lengths(some, level)
    values = values[row]
    values = np.concatenate(
        [np.take_along_axis(values[:, :size], order, 1), np.take_along_axis(values[:, size:], order, 1)],
        axis=1,
    )
    whole = np.floor(values).astype(np.int64)
    if all_ways:
        again, whole = _roundings(values, whole, (tolerance / cell)[row])
        row, order = row[again], order[again]
    # What is hashed besides the lengths is the level and whether the ring is open.
    heads = np.stack([level[row], rings.open[rows[row]].astype(np.int64)], axis=1)
    read = np.concatenate([heads, whole], axis=1)
    words = cell_words(subkey, read, WORDS) if isinstance(subkey, bytes) else subkey(read, cell)
    part = words[:, 0] >> np.uint64(59)
    kind = np.where(part < _HEADERS, HEADER, np.where(part < _HEADERS + _PLACES, PLACE, PAYLOAD))
    return Ways(
        rings=rings,
        shapes=shapes,
        row=rows[row].astype(np.int32),
        order=order.astype(np.int8),
        level=level[row].astype(np.int16),
        words=words,
        kind=kind.astype(np.int8),
    )


def lengths(shapes: RingShapes, level: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the ring's lengths (r, 2k) in units of the hash's step, and that step (r,) in ring sizes."""
    step = step_of(level)
    cell = np.minimum(HASH_STEPS * step, np.maximum(HASH_STEP, shapes.style.hash_least * step))
    return np.concatenate([shapes.distance, shapes.chord], axis=1) / cell[:, None] + _SHIFT, cell


def tolerances(shapes: RingShapes, level: IntArray) -> FloatArray:
    """Return by how much (r,), in ring sizes, a length may be off."""
    return np.asarray(shapes.style.tolerance * step_of(level) / shapes.spread)


def _roundings(values: FloatArray, whole: IntArray, tolerance: FloatArray) -> tuple[IntArray, IntArray]:
    """Return (row, whole): each row of whole numbers with every rounding of its (at most three) doubtful values."""
    off = values - np.round(values)
    near = np.abs(off) <= tolerance[:, None]
    rows, found = [np.arange(len(values))], [whole]
    doubtful = np.flatnonzero(near.any(axis=1))
    rank = np.argsort(np.where(near, np.abs(off), np.inf)[doubtful], axis=1, kind="stable")[:, :AMBIGUOUS]
    counts = near[doubtful].sum(axis=1).clip(max=AMBIGUOUS)
    other = np.where(off < 0.0, 1, -1)
    for choice in product((False, True), repeat=AMBIGUOUS):
        last = max((place + 1 for place, change in enumerate(choice) if change), default=0)
        use = counts >= last
        if not last or not use.any():
            continue
        row, changed = doubtful[use], whole[doubtful[use]].copy()
        for place, change in enumerate(choice):
            if change:
                column = rank[use, place]
                changed[np.arange(len(row)), column] += other[row, column]
        rows.append(row)
        found.append(changed)
    return np.concatenate(rows), np.concatenate(found)

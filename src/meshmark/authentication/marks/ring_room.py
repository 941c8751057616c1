"""The rings of a surface that is to be marked: how much room each has, and what marks at some of them are like."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import (
    Candidates,
    as_laid_out,
    candidates,
    joined,
    level_of,
    room,
)
from meshmark.authentication.marks.ring_shapes import RingShapes, ring_shapes
from meshmark.authentication.marks.ring_ways import step_of
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.words import PURPOSE
from meshmark.authentication.parameters import Layout, Style
from meshmark.coding.keys import Key
from meshmark.geometry.blocks import blocks
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray

__all__ = ["RingRoom", "covered"]

# Rings that are read at once: those of a large model would take gigabytes meanwhile.
_BLOCK = 1 << 16
# Largest swing (`RingShapes`) of a point whose mark is firm.
_SWUNG = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class RingRoom:
    """Rings of p points, of all of them or of some. parts: the rings by size, with their shapes; unit: the smallest
    step, in scene units.
    """

    points: FloatArray
    parts: list[tuple[Rings, RingShapes]]
    unit: float

    @staticmethod
    def of(surface: Surface, unit: float, style: Style, some: NDArray[np.bool_] | None = None) -> RingRoom:
        """Return the rings of a surface for marks of a style; those of `some` points (p,) alone, where given."""
        groups = rings_of(surface)
        if some is not None:
            groups = [group.take(some[group.vertex]) for group in groups]
        parts = [(rings, ring_shapes(surface.points, rings, style)) for rings in groups]
        return RingRoom(points=surface.points, parts=parts, unit=unit)

    @property
    def count(self) -> int:
        """Return the number of rings."""
        return sum(len(group.vertex) for group, _ in self.parts)

    @cached_property
    def levels(self) -> FloatArray:
        """Return (p,): how many levels a mark at each point may have, 0 where it may have none."""
        levels = np.zeros(len(self.points))
        for group, shape in self.parts:
            levels[group.vertex] = room(shape, self.unit)
        return levels

    def doubtful(self, levels: int, doubt: float) -> NDArray[np.bool_]:
        """Return (p,): the points that have it where lengths are off by `doubt` tolerances at most."""
        allowed = np.zeros(len(self.points), bool)
        for group, shape in self.parts:
            allowed[group.vertex] = room(shape, self.unit, doubt=doubt) >= levels
        return allowed

    @cached_property
    def firm(self) -> NDArray[np.bool_]:
        """Return (p,): the points that do not lie so far from the middle of a ring that its turning moves them.

        Others carry marks only where these cannot. What else an error does to a mark's place depends on the ring
        alone (`RingShapes.spread`).
        """
        firm = np.ones(len(self.points), bool)
        for group, shape in self.parts:
            firm[group.vertex] = shape.swing <= _SWUNG
        return firm

    def allowed(self, levels: int) -> NDArray[np.bool_]:
        """Return (p,): the points that have room for marks of this number of levels."""
        return np.asarray(self.levels >= levels)

    def found(self, chosen: NDArray[np.bool_], key: Key, layout: Layout) -> Candidates:
        """Return the plain readings of the chosen (p,) points, as marks of a layout."""
        return as_laid_out(joined(self._plain(chosen, key.subkey(PURPOSE))), layout)

    def _plain(self, chosen: NDArray[np.bool_], subkey: bytes) -> Iterator[Candidates]:
        for rings, shapes in self.parts:
            all_rows = np.flatnonzero(chosen[rings.vertex])
            for block in blocks(max(len(all_rows), 1), _BLOCK):
                rows = all_rows[block]
                some = shapes.take(rows)
                level = np.floor(level_of(some, self.unit)).astype(np.int64)
                yield candidates(self.points, rings.take(rows), some, level, subkey, all_ways=False)

    def rms(self, chosen: NDArray[np.bool_], layout: Layout) -> float:
        """Return the RMS displacement of all points for marks at `chosen` (p,): each axis uniform in its span."""
        square = 0.0
        for group, shape in self.parts:
            some = shape.take(chosen[group.vertex])
            step = some.size * step_of(np.floor(level_of(some, self.unit)).astype(np.int64))
            square += float(step @ step)
        return sqrt(square * sum(each**2 for each in layout.radix) / 12.0 / len(chosen))


def covered(surface: Surface, chosen: NDArray[np.bool_]) -> float:
    """Return which share of the points that rings use is chosen (p,) or in the ring of one that is."""
    vouched, used = chosen.copy(), np.zeros(len(chosen), bool)
    for group in rings_of(surface):
        used[group.around] = True
        vouched[group.around[chosen[group.vertex]]] = True
    return float(vouched.sum() / used.sum())

"""Candidates for marks: where a point lies in its ring, read in one of its ways, and which rings have room for one.

Every candidate counts as a try.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import rows_of
from meshmark.authentication.marks.ring_shapes import RingShapes, frames, spreads_from
from meshmark.authentication.marks.ring_ways import (
    HEADER,
    PAYLOAD,
    PLACE,
    Hash,
    Ways,
    lengths,
    step_of,
    tolerances,
    ways,
)
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.parameters import (
    ALTERNATIVES,
    AMBIGUOUS,
    LEVELS,
    REACH,
    SPREAD,
    SWAY,
    UNREADABLE,
    Layout,
)
from meshmark.coding.keyed import unit_interval
from meshmark.geometry.blocks import append, blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "HEADER", "PAYLOAD", "PLACE", "Beside", "Candidates", "as_laid_out", "beside", "candidates", "eligible",
    "joined", "level_of", "placed", "places_off", "room", "with_beside",
]  # fmt: skip

_TINY: Final = 1e-300
BINDING: Final = slice(3, 7)
"""Which of a ring's keyed numbers bind its symbol: factor, summand, mask and a direction; others place it."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidates:
    """c candidates.

    ring: (c,) the rows of the rings; vertex: (c,) their middle points. centre: (c, 3) the mean of the ring.
    kind: (c,) HEADER, PLACE or PAYLOAD; index: (c,) uint32 of the symbol. name: (c,) uint64 of the ring, the
    first of its keyed numbers; words: (c, 4) uint64, those that the symbol is bound by. place: (c, 3) of the
    point in its ring, in steps, less the dither: a mark has whole numbers here; whole: (c, 3) those that are
    tried. swing: (c,) how many times as far as others errors of its ring move it (`RingShapes`), 1 to `UNREADABLE`.
    boundary: (c,) a bit for each neighbour that is on a boundary, in the ring's order.
    """

    ring: NDArray[np.int32]
    vertex: NDArray[np.int32]
    centre: FloatArray
    kind: NDArray[np.int8]
    index: NDArray[np.uint32]
    name: NDArray[np.uint64]
    words: NDArray[np.uint64]
    place: FloatArray
    whole: IntArray
    swing: FloatArray
    boundary: NDArray[np.int32]

    def take(self, rows: IntArray | NDArray[np.bool_]) -> Candidates:
        """Return these rows."""
        return Candidates(**{field.name: rows_of(getattr(self, field.name), rows) for field in fields(self)})


@dataclass(frozen=True, eq=False, kw_only=True)
class Beside:
    """Whole numbers that are tried beside the nearest ones. row: (b,) of the candidate; whole: (b, 3)."""

    row: IntArray
    whole: IntArray

    def take(self, rows: NDArray[np.bool_]) -> Beside:
        """Return these rows."""
        return Beside(row=rows_of(self.row, rows), whole=rows_of(self.whole, rows))


def joined(parts: Iterable[Candidates]) -> Candidates:
    """Return the candidates of several lists, at least one, in one; of an iterator there is one part at a time."""
    remaining = iter(parts)
    first = next(remaining)
    whole = {field.name: getattr(first, field.name).copy() for field in fields(Candidates)}
    for part in remaining:
        for name, values in whole.items():
            append(values, getattr(part, name))
    return Candidates(**whole)


def as_laid_out(found: Candidates, layout: Layout) -> Candidates:
    """Return the candidates as marks of a layout: all headers where it has pieces of the id only."""
    return replace(found, kind=np.full_like(found.kind, HEADER)) if layout.pieces_only else found


def beside(found: Candidates, chosen: NDArray[np.bool_], least: float) -> Beside:
    """Return the next whole numbers of `chosen` candidates (c,), along all axes on which they are `least` off."""
    off = found.place - found.whole
    next_ = np.where((np.abs(off) >= least) & chosen[:, None], np.sign(off), 0.0).astype(np.int8)
    rows, whole = [], []
    for axes in list(product((0, 1), repeat=3))[1:]:
        some = np.flatnonzero((next_[:, np.array(axes) == 1] != 0).all(axis=1))
        rows.append(some)
        whole.append(found.whole[some] + next_[some] * np.array(axes))
    return Beside(row=np.concatenate(rows), whole=np.concatenate(whole))


def with_beside(found: Candidates, more: Beside) -> Candidates:
    """Return the candidates, and after them the same with the next whole numbers."""
    rows = np.concatenate([np.arange(len(found.vertex)), more.row])
    return replace(found.take(rows), whole=np.concatenate([found.whole, more.whole]))


def places_off(found: Candidates) -> FloatArray:
    """Return (c,) how far the places of candidates are off those tried, in steps, on the axis where farthest."""
    return np.asarray(np.abs(found.place - found.whole).max(axis=1))


def level_of(shapes: RingShapes, unit: float) -> FloatArray:
    """Return (r,): the levels, not rounded down, whose step is `unit` (scene units) times the ring's spread."""
    return np.asarray(2.0 * np.log2(np.maximum(shapes.size / shapes.spread, _TINY) / unit))


def eligible(shapes: RingShapes, unit: float, levels: int, margin: float = 1.0) -> NDArray[np.bool_]:
    """Return (r,): which rings may have a mark, for a step of `unit` (scene units) and `levels` of it.

    With a `margin` above 1 fewer may: those that still do after a small change.
    """
    return np.asarray(room(shapes, unit, margin) >= levels)


def room(shapes: RingShapes, unit: float, margin: float = 1.0, doubt: float | None = None) -> FloatArray:
    """Return (r,): how many levels a mark may have in each ring, 0 where it may have none (see `eligible`).

    doubt: by how many times the tolerance a length may be off; as the margin where it is left out.
    """
    count = len(shapes.size)
    parts = [
        _room(shapes.take(rows), unit, margin, margin if doubt is None else doubt) for rows in blocks(count)
    ]
    return np.concatenate(parts) if parts else np.zeros(0)


def _room(shapes: RingShapes, unit: float, margin: float, doubt: float) -> FloatArray:
    exact = level_of(shapes, unit)
    firm = (exact >= LEVELS[0]) & (shapes.spread * margin <= SPREAD) & shapes.normal.any(axis=1)
    level = np.clip(np.floor(exact), LEVELS[0], LEVELS[-1]).astype(np.int64)
    values, cell = lengths(shapes, level)
    tolerance = doubt * tolerances(shapes, level)
    near = np.abs(values - np.round(values)) <= (tolerance / cell)[:, None]
    ties = shapes.distance >= (shapes.distance.max(axis=1) - tolerance)[:, None]
    clear = (near.sum(axis=1) <= AMBIGUOUS) & (ties.sum(axis=1) <= ALTERNATIVES)
    clear &= _one_level(shapes, exact, ties)
    reach = REACH * 2.0 ** (exact / 2.0) / np.sqrt(2.0)
    turned = (
        2.0 * SWAY * np.sqrt(3.0) * shapes.style.unit * shapes.size / unit / np.maximum(shapes.sway, _TINY)
    )
    return np.asarray(np.where(firm & clear, np.minimum(reach, turned) / margin, 0.0))


def candidates(
    points: FloatArray,
    rings: Rings,
    shapes: RingShapes,
    level: IntArray,
    subkey: bytes | Hash,
    *,
    all_ways: bool,
    only: int | None = None,
) -> Candidates:
    """Return the candidates of rings with these levels (r,): the plain one or `all_ways`, `only` of one kind.

    subkey: see `ways`.
    """
    found = ways(rings, shapes, np.arange(len(rings.vertex)), level, subkey, all_ways=all_ways)
    return placed(points, found if only is None else found.of_kind(only))


def placed(points: FloatArray, found: Ways) -> Candidates:
    """Return the candidates that ways to read rings make of points (p, 3)."""
    rings, shapes, row, order, words = found.rings, found.shapes, found.row, found.order, found.words
    size = rings.around.shape[1]
    offsets = shapes.offsets(row, order)
    axes = frames(offsets, shapes.normal[row])
    base = np.einsum("rki,rk->ri", offsets, _weights(words[:, 1], size)) if shapes.style.pull else 0.0
    vertex, step = rings.vertex[row], step_of(found.level)
    local = (points.take(vertex, axis=0) - shapes.centre.take(row, axis=0)) / shapes.size[row, None] - base
    place = np.einsum("rij,rj->ri", axes, local) / step[:, None] - _dither(words[:, 2])
    index = (words[:, 0] & np.uint64(0xFFFFFFFF)).astype(np.uint32)
    boundary = rings.boundary[row[:, None], order] @ (1 << np.arange(size))
    return Candidates(
        ring=row,
        vertex=vertex.astype(np.int32),
        centre=shapes.centre.take(row, axis=0),
        kind=found.kind,
        index=index,
        name=words[:, 0].copy(),
        words=words[:, BINDING],
        place=place,
        whole=np.round(place).astype(np.int64),
        swing=np.clip(shapes.swing.take(row), 1.0, UNREADABLE),
        boundary=boundary.astype(np.int32),
    )


def _one_level(shapes: RingShapes, exact: FloatArray, ties: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (r,): the rings whose level is the same whichever of the farthest neighbours, `ties`, leads.

    `exact` (r,) is the level, not rounded down, with the farthest of them. The spread depends on the one that
    leads, and rounding may make any of them the farthest.
    """
    same = np.ones(len(exact), bool)
    row, start = np.nonzero(ties)
    several = ties.sum(axis=1)[row] > 1
    row, start = row[several], start[several]
    if len(row):
        tied = shapes.take(row)
        other = exact[row] + 2.0 * np.log2(tied.spread / spreads_from(tied, start))
        same[row[np.floor(other) != np.floor(exact[row])]] = False
    return same


def _weights(word: NDArray[np.uint64], size: int) -> FloatArray:
    """Return (r, k) weights about +-1, of sum 1: half of the neighbours, by a keyed draw, pull, the others push.

    So a neighbour that moves by a step moves the mark's place by about a step, whatever the ring's shape, and a
    smooth stretch of the surface moves it, too.
    """
    draw = (word[:, None] >> (np.uint64(4) * np.arange(size, dtype=np.uint64))) & np.uint64(15)
    rank = np.argsort(np.argsort(draw, axis=1, kind="stable"), axis=1, kind="stable")
    sign = np.where(rank < (size + 1) // 2, 1.0, -1.0)
    return np.asarray(sign + (0.0 if size % 2 else 1.0 / size))


def _dither(word: NDArray[np.uint64]) -> FloatArray:
    """Return (r, 3) numbers in [0, 1)."""
    parts = [(word << np.uint64(21 * axis)) for axis in range(3)]
    return np.stack([unit_interval(part) for part in parts], axis=1)

"""Ways to read a ring: its start, its step and the rounding of its lengths, and the keyed numbers of each.

Where a length lies near a rounding boundary, or two neighbours are about equally far, a file of little
precision may turn the one into the other. Each such reading is a candidate, and every candidate counts as a
try.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.ring_shapes import RingShapes, frames, spreads_from, starts
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.parameters import (
    ALTERNATIVES,
    AMBIGUOUS,
    HASH_STEP,
    HASH_STEPS,
    LEVELS,
    REACH,
    SPREAD,
    SWAY,
    Layout,
)
from meshmark.coding.keyed import cell_words, unit_interval
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "HEADER", "PAYLOAD", "PLACE", "Beside", "Candidates", "as_laid_out", "beside", "candidates", "eligible",
    "joined", "level_of", "room", "step_of", "with_beside",
]  # fmt: skip

HEADER, PLACE, PAYLOAD = 0, 1, 2
"""What the symbol of a mark is: a piece of the model's id, the mark's place, or a symbol of the payload."""
_TINY: Final = 1e-300
# Number of marks in 32 that carry the id, and that carry their place.
_HEADERS: Final = 3
_PLACES: Final = 4
# Lengths such as 1 and 2, which regular rings have, must not lie on a rounding boundary.
_SHIFT: Final = 0.381966


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidates:
    """c candidates.

    ring: (c,) the rows of the rings; vertex: (c,) their middle points. level: (c,) of the step; step: (c,) in scene
    units. axes: (c, 3, 3) rows. centre: (c, 3) the mean of the ring. kind: (c,) HEADER, PLACE or PAYLOAD; index:
    (c,) uint32 of the symbol. words: (c, 7) uint64, the ring's keyed numbers. place: (c, 3) of the point in its
    ring, in steps, less the dither: a mark has whole numbers here; whole: (c, 3) those that are tried. boundary:
    (c,) a bit for each neighbour that is on a boundary, in the ring's order.
    """

    ring: IntArray
    vertex: IntArray
    level: IntArray
    step: FloatArray
    axes: FloatArray
    centre: FloatArray
    kind: IntArray
    index: NDArray[np.uint32]
    words: NDArray[np.uint64]
    place: FloatArray
    whole: IntArray
    boundary: IntArray

    def take(self, rows: IntArray | NDArray[np.bool_]) -> Candidates:
        """Return these rows."""
        return Candidates(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


@dataclass(frozen=True, eq=False, kw_only=True)
class Beside:
    """Whole numbers that are tried beside the nearest ones. row: (b,) of the candidate; whole: (b, 3)."""

    row: IntArray
    whole: IntArray

    def take(self, rows: NDArray[np.bool_]) -> Beside:
        """Return these rows."""
        return Beside(row=self.row[rows], whole=self.whole[rows])


def joined(parts: list[Candidates]) -> Candidates:
    """Return the candidates of several lists, at least one, in one."""
    return Candidates(
        **{
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(Candidates)
        }
    )


def as_laid_out(found: Candidates, layout: Layout) -> Candidates:
    """Return the candidates as marks of a layout: all headers where it has pieces of the id only."""
    return replace(found, kind=np.full(len(found.kind), HEADER)) if layout.pieces_only else found


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


def level_of(shapes: RingShapes, unit: float) -> FloatArray:
    """Return (r,): the levels, not rounded down, whose step is `unit` (scene units) times the ring's spread."""
    return np.asarray(2.0 * np.log2(np.maximum(shapes.size / shapes.spread, _TINY) / unit))


def step_of(level: IntArray) -> FloatArray:
    """Return the steps (r,) of levels, in units of the ring size."""
    return np.asarray(2.0 ** (-np.asarray(level, np.float64) / 2.0))


def eligible(shapes: RingShapes, unit: float, levels: int, margin: float = 1.0) -> NDArray[np.bool_]:
    """Return (r,): which rings may have a mark, for a step of `unit` (scene units) and `levels` of it.

    With a `margin` above 1 fewer may: those that still do after a small change.
    """
    return np.asarray(room(shapes, unit, margin) >= levels)


def room(shapes: RingShapes, unit: float, margin: float = 1.0, doubt: float | None = None) -> FloatArray:
    """Return (r,): how many levels a mark may have in each ring, 0 where it may have none (see `eligible`).

    doubt: by how many times the tolerance a length may be off; as the margin where it is left out.
    """
    exact = level_of(shapes, unit)
    firm = (exact >= LEVELS[0]) & (shapes.spread * margin <= SPREAD) & shapes.normal.any(axis=1)
    level = np.clip(np.floor(exact), LEVELS[0], LEVELS[-1]).astype(np.int64)
    values, cell = _lengths(shapes, level)
    tolerance = (margin if doubt is None else doubt) * _tolerance(shapes, level)
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
    subkey: bytes,
    *,
    all_ways: bool,
    only: int | None = None,
) -> Candidates:
    """Return the candidates of rings with these levels (r,): the plain one or `all_ways`, `only` of one kind."""
    step = step_of(level)
    tolerance = _tolerance(shapes, level)
    row, first = starts(shapes.distance, tolerance if all_ways else np.zeros(len(step)))
    if not all_ways:
        row, unique = np.unique(row, return_index=True)
        first = first[unique]
    size = rings.around.shape[1]
    order = (first[:, None] + np.arange(size)) % size
    values, cell = _lengths(shapes, level)
    values = values[row]
    values = np.concatenate(
        [np.take_along_axis(values[:, :size], order, 1), np.take_along_axis(values[:, size:], order, 1)],
        axis=1,
    )
    whole = np.floor(values).astype(np.int64)
    if all_ways:
        again, whole = _roundings(values, whole, (tolerance / cell)[row])
        row, order = row[again], order[again]
    words = cell_words(subkey, np.concatenate([_heads(rings, level)[row], whole], axis=1), 7)
    kind = (words[:, 0] >> np.uint64(59)).astype(np.int64)
    kind = np.where(kind < _HEADERS, HEADER, np.where(kind < _HEADERS + _PLACES, PLACE, PAYLOAD))
    if only is not None:
        kept = np.flatnonzero(kind == only)
        row, order, words, kind = row[kept], order[kept], words[kept], kind[kept]
    offsets = shapes.offsets[row[:, None], order]
    axes = frames(offsets, shapes.normal[row])
    base = np.einsum("rki,rk->ri", offsets, _weights(words[:, 1], size)) if shapes.style.pull else 0.0
    vertex = rings.vertex[row]
    local = (points[vertex] - shapes.centre[row]) / shapes.size[row, None] - base
    place = np.einsum("rij,rj->ri", axes, local) / step[row, None] - _dither(words[:, 2])
    index = (words[:, 0] & np.uint64(0xFFFFFFFF)).astype(np.uint32)
    boundary = rings.boundary[row[:, None], order] @ (1 << np.arange(size))
    return Candidates(
        ring=row,
        vertex=vertex,
        level=level[row],
        step=step[row] * shapes.size[row],
        axes=axes,
        centre=shapes.centre[row],
        kind=kind,
        index=index,
        words=words,
        place=place,
        whole=np.round(place).astype(np.int64),
        boundary=boundary,
    )


def _lengths(shapes: RingShapes, level: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the ring's lengths (r, 2k) in units of the hash's step, and that step (r,) in ring sizes."""
    step = step_of(level)
    cell = np.minimum(HASH_STEPS * step, np.maximum(HASH_STEP, shapes.style.hash_least * step))
    return np.concatenate([shapes.distance, shapes.chord], axis=1) / cell[:, None] + _SHIFT, cell


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


def _tolerance(shapes: RingShapes, level: IntArray) -> FloatArray:
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


def _heads(rings: Rings, level: IntArray) -> IntArray:
    """Return (r, 2): what is hashed besides the lengths, the level and whether the ring is open."""
    return np.stack([level, rings.open.astype(np.int64)], axis=1)


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

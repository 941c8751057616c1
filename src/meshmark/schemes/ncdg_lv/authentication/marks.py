"""Marks: which points carry them, and where those points go (DESIGN section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log10, sqrt

import numpy as np
from numpy.typing import NDArray

from meshmark.carriers.rings import Rings, ordered_rings
from meshmark.carriers.rings_independent import independent_points
from meshmark.carriers.rings_shape import RingShapes, ring_shapes
from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray, IntArray
from meshmark.schemes.ncdg_lv.authentication.candidates import (
    HEADER,
    PAYLOAD,
    PLACE,
    Candidates,
    candidates,
    eligible,
    joined,
    level_of,
)
from meshmark.schemes.ncdg_lv.authentication.parameters import (
    DEVIATIONS,
    LAYOUTS,
    MARK_SHARE,
    MARKS_NEEDED,
    PSNR_LEAST,
    PSNR_WANTED,
    SPREAD,
    Layout,
)
from meshmark.schemes.ncdg_lv.authentication.symbols import header_symbols, place_symbols
from meshmark.schemes.ncdg_lv.authentication.words import PURPOSE, bind, places_of, words_of

__all__ = ["Marked", "Plan", "SymbolSource", "mark", "plan"]

SymbolSource = Callable[[NDArray[np.uint32]], NDArray[np.uint16]]


@dataclass(frozen=True, eq=False)
class Plan:
    """What a surface can carry.

    marks: (m,) the points that carry marks. payload_marks: how many of them carry payload.
    payload_index: (payload_marks,) uint32 of their symbols; rings that are alike share one.
    layout: bits per mark. unit: smallest step, in scene units.
    """

    marks: IntArray
    payload_index: NDArray[np.uint32]
    layout: Layout
    unit: float

    @property
    def symbol_bits(self) -> int:
        """Return the bits of a payload symbol."""
        return self.layout.symbol

    @property
    def payload_marks(self) -> int:
        """Return the number of marks that carry payload."""
        return len(self.payload_index)


@dataclass(frozen=True, eq=False)
class Marked:
    """A marked surface.

    points: (p, 3). count: marks. bits_per_mark: symbol and MAC; symbol_bits: the symbol alone. step: the smallest
    quantiser step, in scene units; no mark has a step 1.42 times as large.
    """

    points: FloatArray
    count: int
    bits_per_mark: int
    symbol_bits: int
    step: float


def plan(surface: Welded, key: Key, precision: float) -> Plan:
    """Choose the marks and their size, for coordinates that may be off by up to `precision` (scene units).

    Raises `InputError` for a precision that is not a positive number, `CapacityError` where the surface has too few
    rings that are large enough.
    """
    plan, _ = _prepared(surface, key, precision)
    return plan


def mark(surface: Welded, key: Key, nonce: int, symbols: SymbolSource, precision: float) -> Marked:
    """Return the surface with marks that are bound to the key, the nonce (the model's id) and the place.

    symbols: the payload's symbols for indices, (m,) uint32 -> (m,) uint16. Raises as `plan` does.
    """
    if not 0 <= nonce < 1 << 64:
        raise InputError("the model's id is out of range, expected a number of 64 bits")
    chosen, found = _prepared(surface, key, precision)
    layout = chosen.layout
    symbol = np.zeros(len(found.vertex), np.int64)
    header, place, payload = (found.kind == kind for kind in (HEADER, PLACE, PAYLOAD))
    symbol[header] = header_symbols(found.index[header], nonce, layout.symbol)
    symbol[place] = place_symbols(found.take(place), _frame(surface), layout.symbol)
    symbol[payload] = symbols(found.index[payload])
    if symbol.max(initial=0) >> layout.symbol:
        raise InputError(f"a payload symbol is out of range, expected {layout.symbol} bits")
    words = words_of(symbol, bind(found, key, nonce), layout)
    change = places_of(words, found.place, layout) - found.place
    points = surface.points.copy()
    points[found.vertex] += np.einsum("rj,rji->ri", change * found.step[:, None], found.axes)
    return Marked(points, len(found.vertex), layout.bits, layout.symbol, chosen.unit)


def _prepared(surface: Welded, key: Key, precision: float) -> tuple[Plan, Candidates]:
    if not (np.isfinite(precision) and precision > 0.0):
        raise InputError(f"a precision of {precision:g} is out of range, expected a number above 0")
    points, faces = surface.points, surface.faces
    unit = 2.0 * DEVIATIONS * SPREAD / sqrt(3.0) * precision
    layout = _layout(unit, _diagonal(surface))
    rings = ordered_rings(faces, len(points))
    shapes = [ring_shapes(points, group) for group in rings]
    usable = [eligible(shape, unit, layout.levels) for shape in shapes]
    allowed = np.zeros(len(points), bool)
    for group, good in zip(rings, usable, strict=True):
        allowed[group.vertex[good]] = True
    chance = unit_interval(keyed_words(key.subkey("authentication choice of marks"), len(points)))
    chosen = independent_points(faces, allowed, chance)
    if chosen.sum() < MARKS_NEEDED:
        raise CapacityError(
            f"the model has room for {int(chosen.sum())} marks of authentication, needs {MARKS_NEEDED}; "
            "it has too few points, or too fine ones for the precision of its file"
        )
    found = joined(
        [_plain(points, group, shape, chosen, unit, key) for group, shape in zip(rings, shapes, strict=True)]
    )
    index = found.index[found.kind == PAYLOAD]
    return Plan(found.vertex, index, layout, unit), found


def _plain(
    points: FloatArray, rings: Rings, shapes: RingShapes, chosen: NDArray[np.bool_], unit: float, key: Key
) -> Candidates:
    rows = np.flatnonzero(chosen[rings.vertex])
    shapes = shapes.take(rows)
    level = np.floor(level_of(shapes.size, unit)).astype(np.int64)
    return candidates(points, rings.take(rows), shapes, level, key.subkey(PURPOSE), all_ways=False)


def _layout(unit: float, diagonal: float) -> Layout:
    """Return the layout with most bits that moves the points little enough."""
    for wanted in (PSNR_WANTED, PSNR_LEAST):
        for layout in LAYOUTS.values():
            # Uniform in the span of each of three axes; steps are spread evenly over a factor sqrt 2.
            rms = layout.levels * unit * sqrt(1.44 * 3.0 / 12.0 * MARK_SHARE)
            if -20.0 * log10(rms / diagonal) >= wanted:
                return layout
    raise CapacityError(
        "the precision of the file is too coarse for invisible marks of authentication; a file with more digits may do"
    )


def _diagonal(surface: Welded) -> float:
    return 2.0 * _frame(surface)[1]


def _frame(surface: Welded) -> tuple[FloatArray, float]:
    """Return the middle and half the diagonal of the box around the points that faces use."""
    used = np.zeros(len(surface.points), bool)
    used[surface.faces] = True
    if not used.any():
        raise CapacityError("the model has no faces, which marks of authentication need")
    low, high = surface.points[used].min(axis=0), surface.points[used].max(axis=0)
    return (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0

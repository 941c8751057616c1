"""Marks: which points carry them, and where those points go (docs/design.md, section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import HEADER, PAYLOAD, PLACE, Candidates, joined
from meshmark.authentication.marks.choice import alike, completed
from meshmark.authentication.marks.component_headers import headers_first
from meshmark.authentication.marks.model_cells import cells_of, masks
from meshmark.authentication.marks.moved_marks import moved_marks
from meshmark.authentication.marks.ring_room import RingRoom, covered
from meshmark.authentication.marks.symbols import covers_id, header_symbols, pieces_of_id, place_symbols
from meshmark.authentication.marks.words import bind, places_of, words_of
from meshmark.authentication.parameters import (
    COVERING,
    FINE,
    PSNR_LEAST,
    PSNR_WANTED,
    SMALL_RINGS,
    SPARSEST,
    Layout,
    Style,
)
from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Marked", "Plan", "SymbolSource", "mark", "plan"]

# Fewest of the points that may be marks that then are, about: what needs more room than this is not tried.
_MARK_SHARE = 0.22
# Where each piece of the id is carried by fewer marks than this on average, none is given up for its ring.
_AMPLE = 6
# How often other points are looked for where rings of marks that tell the id are alike.
_UNALIKE = 3
# Fewest marks that carry their place of a model whose symbols are bound to places; half of them do so coarsely.
_PLACING = 48
SymbolSource = Callable[[NDArray[np.uint32]], NDArray[np.uint16]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """What a surface can carry; `mark` writes it.

    surface: that is to be marked. found: the m marks as their rings read before. style, layout: of the marks, and
    their bits. unit: smallest step, in scene units. covered: share of the points that faces use which are marks or
    in the ring of one, 0 to 1.
    """

    surface: Surface = field(repr=False)
    found: Candidates = field(repr=False)
    style: Style
    layout: Layout
    unit: float
    covered: float

    @cached_property
    def payload_index(self) -> NDArray[np.uint32]:
        """Return (payload_marks,): the indices of the payload symbols; rings that are alike share one."""
        return np.asarray(self.found.index[self.found.kind == PAYLOAD])

    @cached_property
    def carries_id(self) -> bool:
        """Return whether the marks carry every piece of the model's id."""
        return covers_id(self.found.index[self.found.kind == HEADER], self.layout.symbol)

    @cached_property
    def once(self) -> bool:
        """Return whether no two marks that tell the id have rings that are alike."""
        return not len(alike(self.found))

    @property
    def marks(self) -> NDArray[np.int32]:
        """Return the points that carry marks (m,)."""
        return self.found.vertex

    @property
    def symbol_bits(self) -> int:
        """Return the bits of a payload symbol."""
        return self.layout.symbol

    @property
    def places_itself(self) -> bool:
        """Return whether enough marks tell where they lie for a reader to know where the model does."""
        return int((self.found.kind == PLACE).sum()) >= _PLACING

    @property
    def payload_marks(self) -> int:
        """Return the number of marks that carry payload."""
        return len(self.payload_index)


@dataclass(frozen=True, eq=False, kw_only=True)
class Marked:
    """A marked surface.

    points: (p, 3). place: (m, 3) whole numbers, where each mark lies in its ring, in steps less the dither
    (`Candidates`). count: marks. bits_per_mark: symbol and MAC; symbol_bits: the symbol alone. step: the smallest
    quantiser step, in scene units; no mark has a step 1.42 times as large.
    """

    points: FloatArray
    place: IntArray
    count: int
    bits_per_mark: int
    symbol_bits: int
    step: float


def plan(surface: Surface, key: Key, precision: float, choice: int = 0, style: Style = FINE) -> Plan:
    """Choose the marks of a surface and their size.

    Parameters
    ----------
    surface : Surface
    key : Key
    precision : float
        By how much coordinates may be off, in scene units.
    choice : int
        Another number gives other marks.
    style : Style
        Of `STYLES`.

    Returns
    -------
    Plan

    Raises
    ------
    InputError
        The precision is not a positive number.
    CapacityError
        The surface has too few rings that are large enough.
    """
    if not (np.isfinite(precision) and precision > 0.0):
        raise InputError(f"a precision of {precision:g} is out of range, expected a number above 0")
    unit = style.unit * precision
    radius = _frame(surface)[1]
    rings = RingRoom.of(surface, unit, style)
    purpose = "authentication choice of marks" + (f" {choice}" if choice else "")
    chance = unit_interval(keyed_words(key.subkey(purpose), len(surface.points)))
    firm = rings.firm
    enough = COVERING * rings.allowed(min(layout.levels for layout in style.layouts)).sum()
    for wanted in (PSNR_WANTED, PSNR_LEAST):
        most = 2.0 * radius * 10.0 ** (-wanted / 20.0)
        for layout in style.layouts:
            allowed = rings.allowed(layout.levels)
            if allowed.sum() < enough or rings.rms(allowed, layout) * sqrt(_MARK_SHARE) > most:
                continue
            chosen = completed(surface.connectivity, np.zeros_like(allowed), allowed, (firm,), chance)
            if rings.rms(chosen, layout) <= most:
                sparsest = ceil(SPARSEST * rings.count) if rings.count > SMALL_RINGS else 0
                least = max(style.least, sparsest)
                if chosen.sum() < least:
                    raise CapacityError(
                        f"the model has room for {int(chosen.sum())} marks of authentication, needs "
                        f"{least}; it has too few points, or too fine ones for the precision of its file"
                    )
                found = rings.found(chosen, key, layout)
                first = headers_first(surface, rings, found, layout, key=key, chance=chance)
                if first.any():
                    chosen = completed(surface.connectivity, first, allowed, (firm,), chance)
                    found = rings.found(chosen, key, layout)
                ample = (found.kind == HEADER).sum() >= _AMPLE * pieces_of_id(layout.symbol)
                unlike = np.ones_like(chosen)
                for _ in range(_UNALIKE if ample else 0):
                    gone = alike(found, first)
                    if not len(gone):
                        break
                    # Others are taken where they can be for marks of rings that are alike.
                    unlike[gone] = False
                    before, chosen = chosen, chosen.copy()
                    chosen[gone] = False
                    chosen = completed(surface.connectivity, chosen, allowed, (firm & unlike, firm), chance)
                    added = rings.found(chosen & ~before, key, layout)
                    found = joined([found.take(chosen[found.vertex]), added])
                return Plan(
                    surface=surface,
                    found=found,
                    style=style,
                    layout=layout,
                    unit=unit,
                    covered=covered(surface, chosen),
                )
    raise CapacityError(
        "the precision of the file is too coarse for invisible marks of authentication, expected more digits"
    )


def mark(plan: Plan, key: Key, nonce: int, symbols: SymbolSource, *, bound: bool = False) -> Marked:
    """Return a surface with the marks that were planned, bound to the key, the nonce and the place.

    Parameters
    ----------
    plan : Plan
        Made with the same key.
    key : Key
    nonce : int
        The model's 64-bit id.
    symbols : callable
        The payload's symbols for indices, (m,) uint32 -> (m,) uint16.
    bound : bool
        Bind symbols to their cells in the model (`model_cells`), which a reader must then find.

    Returns
    -------
    Marked

    Raises
    ------
    InputError
        The id or a symbol is out of range.
    """
    if not 0 <= nonce < 1 << 64:
        raise InputError("the model's id is out of range, expected a number of 64 bits")
    surface, found, layout = plan.surface, plan.found, plan.layout
    symbol = np.zeros(len(found.vertex), np.int64)
    header, place, payload = (found.kind == kind for kind in (HEADER, PLACE, PAYLOAD))
    symbol[header] = header_symbols(found.index[header], nonce, layout.symbol)
    symbol[place] = place_symbols(found.take(place), _frame(surface), layout.symbol)
    symbol[payload] = symbols(found.index[payload])
    if symbol.max(initial=0) >> layout.symbol:
        raise InputError(f"a payload symbol is out of range, expected {layout.symbol} bits")
    if bound:
        middle, radius = _frame(surface)
        cells = cells_of((found.centre[payload] - middle) / radius, layout.symbol)
        symbol[payload] ^= masks(key, nonce, layout.symbol)(found.name[payload], cells)
    words = words_of(symbol, found.boundary, bind(found, key, nonce), layout)
    place = places_of(words, found.place, layout)
    change = place - found.place
    return Marked(
        points=moved_marks(surface, plan.unit, plan.style, found.vertex, change),
        place=place,
        count=len(found.vertex),
        bits_per_mark=layout.bits,
        symbol_bits=layout.symbol,
        step=plan.unit,
    )


def _frame(surface: Surface) -> tuple[FloatArray, float]:
    """Return the middle and half the diagonal of the box around the points that faces use."""
    if not surface.used.any():
        raise CapacityError("the model has no faces, which marks of authentication need")
    used = surface.points[surface.used]
    return (used.min(axis=0) + used.max(axis=0)) / 2.0, surface.diagonal / 2.0

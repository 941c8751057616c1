"""Reading candidates: which of them are marks, and how likely that is by chance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log, log10

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import rows_of, sorted_distinct
from meshmark.authentication.checks.carried import Expected, carried
from meshmark.authentication.marks.candidates import HEADER, PAYLOAD, PLACE, Beside, Candidates, places_off
from meshmark.authentication.marks.symbols import header_symbols, outvoted
from meshmark.authentication.marks.words import bind, symbols_at
from meshmark.authentication.parameters import WAYS, Layout
from meshmark.coding.keys import Key
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Read", "beyond_luck", "chance_of", "read_marks", "window_of"]

# A mark may be this number of steps from its whole place, and a number of times the median of all more.
_WINDOW = 0.12
# Nats beyond luck at which marks are worth a closer look: one surface in 30 without any has them.
_WORTH = 3.5
# Candidates read at once: each takes a kilobyte meanwhile.
_BLOCK = 1 << 17
# Odd numbers that make three whole places into one.
_MIX = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)


@dataclass(frozen=True, eq=False, kw_only=True)
class Read:
    """What candidates say: symbols (c,), whether a mark holds, how far it is off, in steps, and whether it holds
    only if its ring was not on a boundary when it was made.
    """

    symbol: IntArray
    holds: NDArray[np.bool_]
    off: FloatArray
    new_boundary: NDArray[np.bool_]

    def take(self, rows: IntArray) -> Read:
        """Return these rows."""
        return Read(
            symbol=rows_of(self.symbol, rows),
            holds=rows_of(self.holds, rows),
            off=rows_of(self.off, rows),
            new_boundary=rows_of(self.new_boundary, rows),
        )


def read_marks(
    found: Candidates,
    key: Key,
    layout: Layout,
    nonce: int | None,
    payload: Expected | None = None,
    *,
    more: Beside | None = None,
) -> Read:
    """Return which candidates are marks; those of headers alone where the nonce (the model's id) is unknown.

    Of headers of a small model that say different pieces of an unknown id, those hold that say what most do.

    Marks lie as near to whole places as the file's precision lets them; how near that is, the marks show, of
    those that swing by their swing. What lies farther off holds by chance, or was moved by less than a step. A
    mark beside a boundary that would hold if there were none is a mark beside a hole that was made.
    payload: the expected symbols, where they have been decoded: a mark that says another one does not hold.
    more: whole places that are read after the others; they need not be made into candidates, which take room.
    """
    off, of, whole = places_off(found), np.arange(len(found.vertex)), found.whole
    if more is not None:
        off = np.concatenate([off, np.abs(found.place[more.row] - more.whole).max(axis=1)])
        of, whole = np.concatenate([of, more.row]), np.concatenate([whole, more.whole])
    symbol = np.zeros(len(off), np.int64)
    holds, new_boundary = np.zeros(len(off), bool), np.zeros(len(off), bool)
    swung = off / found.swing[of]
    last, window = -1.0, _WINDOW
    while window > last:  # a narrow window first: few files need more
        within = np.flatnonzero((swung > last) & (swung <= window))
        for block in blocks(len(within), _BLOCK):  # a large model has ten million
            rows = within[block]
            some = replace(found.take(of[rows]), whole=whole[rows])
            symbol[rows], holds[rows], new_boundary[rows] = _read(some, key, layout, nonce, payload)
        last = window
        window = window_of(swung[holds], layout)
    holds &= swung <= window
    if nonce is None and layout.pieces_only:
        holds &= ~outvoted(found.index[of], symbol, layout.symbol, holds)
    return Read(symbol=symbol, holds=holds, off=off, new_boundary=new_boundary & holds)


def window_of(off: FloatArray, layout: Layout) -> float:
    """Return how far off its whole place, in steps, a mark may be where those that hold are `off` (k,)."""
    return _WINDOW + layout.window * float(np.median(off)) if len(off) else 1.0


def _read(
    found: Candidates, key: Key, layout: Layout, nonce: int | None, payload: Expected | None
) -> tuple[IntArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the symbols (c,) of the whole places, whether they hold, and whether only without a boundary."""
    whole = found.whole
    bound = bind(found, key, nonce)
    symbol, holds = symbols_at(whole, found.boundary, bound, layout)
    new_boundary = np.zeros(len(whole), bool)
    rows = np.flatnonzero((found.boundary != 0) & ~holds)
    new_boundary[rows] = symbols_at(whole[rows], np.zeros(len(rows), np.int64), bound[rows], layout)[1]
    holds |= new_boundary
    if nonce is not None:
        header = found.kind == HEADER
        holds[header] &= symbol[header] == header_symbols(found.index[header], nonce, layout.symbol)
    if payload is not None:
        rows = np.flatnonzero(holds & (found.kind == PAYLOAD))
        holds[rows] = payload.agrees(carried(found.take(rows), symbol[rows]))
        rows = np.flatnonzero(holds & (found.kind == PLACE))
        holds[rows] = payload.in_place(found.take(rows), symbol[rows])
    return symbol, holds, new_boundary


def chance_of(
    found: Candidates,
    holds: NDArray[np.bool_],
    layout: Layout,
    more: Beside | None = None,
    *,
    without_boundary: bool = True,
) -> float:
    """Bound the chance that as many marks hold by luck, times all layouts and levels (Chernoff).

    Words that are alike in rings that are alike count once: they hold or fail together. How many are tried depends
    on what holds, so all numbers of tries count. more: tries besides, none of which holds. without_boundary: marks
    beside a boundary were read as if there were none, too, as `read_marks` does, which are two tries.
    """
    total, nats = _against_luck(found, holds, layout, more, without_boundary=without_boundary)
    return min(0.0, log10(WAYS * max(total, 1)) - nats / log(10.0))


def beyond_luck(found: Candidates, holds: NDArray[np.bool_], layout: Layout) -> bool:
    """Return whether more marks hold than luck alone lets hold in one of some 30 surfaces.

    What fails this needs no further reading: it is far from `chance_of` being small.
    """
    return _against_luck(found, holds, layout)[1] > _WORTH


def _against_luck(
    found: Candidates,
    holds: NDArray[np.bool_],
    layout: Layout,
    more: Beside | None = None,
    *,
    without_boundary: bool = True,
) -> tuple[int, float]:
    """Return how many different marks were tried, and the exponent (nats) of Chernoff's bound."""
    tries, boundary = _names(found.name, found.whole, layout), found.boundary
    held = len(sorted_distinct(tries[holds]))
    if more is not None:
        tries = np.concatenate([tries, _names(found.name[more.row], more.whole, layout)])
        boundary = np.concatenate([boundary, boundary[more.row]])
    total = len(sorted_distinct(tries))
    if without_boundary:
        total += len(sorted_distinct(tries[boundary != 0]))
    luck = 2.0**-layout.check
    share = held / max(total, 1)
    if share <= luck:
        return total, 0.0
    rest = 0.0 if share >= 1.0 else (1.0 - share) * log((1.0 - share) / (1.0 - luck))
    return total, total * (share * log(share / luck) + rest)


def _names(ring: NDArray[np.uint64], whole: IntArray, layout: Layout) -> NDArray[np.uint64]:
    """Return one number (c,) each for words in rings (c,), of the whole places (c, 3) that say them."""
    return np.asarray(ring ^ ((whole % np.array(layout.radix)).view(np.uint64) @ _MIX))

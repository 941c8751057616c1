"""Marks that tell the id in every large component of a surface, so that a component taken out tells it by itself.

Three marks in 32 tell the id (`ring_ways`), which one they are is hashed from their rings. A component of some
hundred points has fewer of them than the id has pieces, unless they are chosen before all others.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import HEADER, Candidates
from meshmark.authentication.marks.independent_points import independent_points
from meshmark.authentication.marks.ring_room import RingRoom
from meshmark.authentication.marks.symbols import pieces_of_id
from meshmark.authentication.parameters import Layout
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.large_components import MOST_MARKED, large_components

__all__ = ["headers_first"]

# A component lacks marks that tell the id where some piece of it is carried by fewer than the first of these; then
# up to the second are chosen for each piece.
_ENOUGH, _WANTED = 2, 3


def headers_first(
    surface: Surface, rings: RingRoom, found: Candidates, layout: Layout, *, key: Key, chance: FloatArray
) -> NDArray[np.bool_]:
    """Return (p,): points, no two of them neighbours, whose marks should be chosen before all others.

    They tell the id in those large components in which the marks of a plan do not. Of rings that are alike one at
    most is among them: a reader takes their marks for copies of each other.

    Parameters
    ----------
    surface : Surface
        Of p points.
    rings : RingRoom
        Of the surface.
    found : Candidates
        The marks of the plan.
    layout : Layout
        Of the marks.
    key : Key
    chance : (p,) float array
        Keyed; the least comes first.

    Returns
    -------
    (p,) bool array
        All false where nothing is lacking, as on any surface in one piece.
    """
    first = np.zeros(len(chance), bool)
    components = () if layout.pieces_only else large_components(surface, MOST_MARKED)
    pieces = pieces_of_id(layout.symbol)
    told = _headers(found, chance)
    told = told.take(np.sort(np.unique(told.name, return_index=True)[1]))
    lacking = [each for each in components if min(map(len, _by_piece(told, each, pieces))) < _ENOUGH]
    if not lacking:
        return first
    able = rings.allowed(layout.levels) & rings.firm & np.logical_or.reduce(lacking)
    header = _headers(rings.found(able, key, layout), chance)
    able[:] = False
    able[header.vertex] = True
    header = header.take(independent_points(surface.connectivity.edges, able, chance)[header.vertex])
    first[header.vertex[_dealt([_by_piece(header, each, pieces) for each in lacking], header)]] = True
    return first


def _headers(found: Candidates, chance: FloatArray) -> Candidates:
    """Return the marks that tell the id, by their `chance` (p,)."""
    header = found.take(found.kind == HEADER)
    return header.take(np.argsort(chance[header.vertex], kind="stable"))


def _by_piece(header: Candidates, component: NDArray[np.bool_], pieces: int) -> list[IntArray]:
    """Return the rows of the marks in a component (p,) that carry each piece of the id."""
    piece = np.where(component[header.vertex], header.index.astype(np.int64) % pieces, -1)
    return [np.flatnonzero(piece == each) for each in range(pieces)]


def _dealt(rows: list[list[IntArray]], header: Candidates) -> list[int]:
    """Return rows of marks, up to `_WANTED` for each component and piece, of rings of which no two are alike.

    rows: for each component and each piece. Components that are alike share their rings: each takes one in turn.
    """
    ring = header.name.tolist()
    taken: set[int] = set()
    chosen = []
    for turn, piece in product(range(_WANTED), range(len(rows[0]))):
        for number in range(len(rows)):
            own = rows[(number + turn + piece) % len(rows)][piece]
            row = next((each for each in own.tolist() if ring[each] not in taken), None)
            if row is not None:
                taken.add(ring[row])
                chosen.append(row)
    return chosen

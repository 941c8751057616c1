"""Tries at a marked model whose points move while its faces stay: which of them may pass, many at once.

A model is authentic only where every point whose ring could carry a mark lies in the closed ring of one that
holds (`altered_points` is empty only then). So a few points of a try are judged first, with all that
may speak for it: every reading of the rings around them, a wide window, no demand on place or payload. A point that
has no voucher even so has none for `authenticate`, and the try is lost; those that are left are for it to judge.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import meshmark as mm
from meshmark.authentication.checks.ring_reading import window_of
from meshmark.authentication.checks.setting_search import Setting, all_candidates, likeliest_setting
from meshmark.authentication.checks.sweep import Sweep, sweep
from meshmark.authentication.examination import examine
from meshmark.authentication.marks.candidates import (
    HEADER,
    Candidates,
    beside,
    eligible,
    joined,
    with_beside,
)
from meshmark.authentication.marks.ring_shapes import RingShapes, ring_shapes
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.symbols import header_symbols
from meshmark.authentication.marks.words import PURPOSE, bind, symbols_at
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Vouching"]

# A try may change how the step is estimated, and how far off marks may be: by less than this.
_MORE_DOUBT, _WIDER = 0.1, 1.5
# Rings that could have a mark by so much count; `authenticate` counts those of 1.1 and more.
_MARGIN = 1.17
_BESIDE = 0.15
# Number of moved points of a try that are judged first.
_FIRST = 3


class Vouching:
    """The rings of a model that is authentic, and which of its marks hold.

    surface: the model by points; held: (p,) which marks hold; sure: (p,) points that surely need a voucher.
    typical_step: of a ring of median spread, in scene units, as it is rounded up at most.
    """

    def __init__(self, mesh: mm.Mesh, key: mm.Key) -> None:
        self.surface = weld(mesh)
        points = self.surface.points
        self._key, self._subkey = key, key.subkey(PURPOSE)
        self._rings = rings_of(self.surface)
        parts = [(rings, ring_shapes(points, rings)) for rings in self._rings]
        setting, swept = _read_as_examined(mesh, points, parts, key)
        holds = swept.read.holds
        self.held = np.zeros(len(points), bool)
        self.held[swept.found.vertex[holds]] = True
        self.sure = np.zeros(len(points), bool)
        self._group, self._row = np.full((2, len(points)), -1)
        for number, (group, shape) in enumerate(parts):
            firm = eligible(shape, setting.unit, setting.layout.levels, _MARGIN)
            self.sure[group.vertex] = firm & swept.able[group.vertex]
            self._group[group.vertex] = number
            self._row[group.vertex] = np.arange(len(group.vertex))
        spread = np.concatenate([shape.spread for _, shape in parts])
        self.typical_step = float(np.median(spread)) * sqrt(2.0) * setting.unit
        self._setting = replace(setting, doubt=setting.doubt + _MORE_DOUBT)
        self._window = _WIDER * window_of(swept.read.off[holds], setting.layout)
        self._rounded, self._nonce = swept.rounded, swept.nonce
        graph = adjacency(unique_edges(self.surface.faces), len(points)).astype(bool)
        graph.setdiag(True)
        self.near = csr_array(graph)
        """(p, p): each point and its neighbours."""

    def may_pass(self, tries: FloatArray, rng: np.random.Generator) -> NDArray[np.bool_]:
        """Return (t,): which tries, points (t, p, 3), may be authentic; to `authenticate` the others are not."""
        touched = (tries != self.surface.points).any(axis=2)
        chance = np.where(touched & self.sure, rng.random(touched.shape), 2.0)
        first = np.argpartition(chance, _FIRST, axis=1)[:, :_FIRST]
        pairs = np.stack([np.repeat(np.arange(len(tries)), _FIRST), first.ravel()], axis=1)
        pairs = pairs[(touched & self.sure)[tuple(pairs.T)]]
        passing = ~self._lost(tries, touched, pairs)
        shaken = (self.near @ (self.near @ touched[passing].T)).T & self.sure
        rest = np.argwhere(shaken)
        rest[:, 0] = np.flatnonzero(passing)[rest[:, 0]]
        return np.asarray(passing & ~self._lost(tries, touched, rest))

    def _lost(self, tries: FloatArray, touched: NDArray[np.bool_], pairs: IntArray) -> NDArray[np.bool_]:
        """Return (t,): the tries of which one of the points, pairs (k, 2) of try and point, has no voucher."""
        lost = np.zeros(len(tries), bool)
        if not len(pairs):
            return lost
        owner, voucher = _entries(self.near, pairs[:, 1])
        moved = (self.near @ touched.T).T  # whose closed ring has a point that moved
        attempt = pairs[owner, 0]
        fresh = moved[attempt, voucher] & (self._group[voucher] >= 0)
        holds = self.held[voucher] & ~moved[attempt, voucher]
        asked, place = np.unique(attempt[fresh] * touched.shape[1] + voucher[fresh], return_inverse=True)
        holds[fresh] = self._hold(tries.reshape(-1, 3), asked)[place]
        vouched = np.zeros(len(pairs), bool)
        vouched[owner[holds]] = True
        lost[pairs[~vouched, 0]] = True
        return lost

    def _hold(self, points: FloatArray, asked: IntArray) -> NDArray[np.bool_]:
        """Return (k,): whether the marks in the middle of rings may hold, points `asked` (k,) of t * p."""
        count = len(self.surface.points)
        holds = np.zeros(len(asked), bool)
        found = []
        for number, group in enumerate(self._rings):
            rows = np.flatnonzero(self._group[asked % count] == number)
            if not len(rows):
                continue
            own, shift = group.take(self._row[asked[rows] % count]), asked[rows] // count * count
            rings = Rings(
                vertex=own.vertex + shift,
                around=own.around + shift[:, None],
                open=own.open,
                boundary=own.boundary,
            )
            found.append(
                all_candidates(points, rings, ring_shapes(points, rings), self._setting, self._subkey)
            )
        if not found:
            return holds
        ways = joined(found)
        if self._rounded:
            ways = with_beside(ways, beside(ways, np.ones(len(ways.vertex), bool), _BESIDE))
        holds[np.searchsorted(asked, ways.vertex[self._may_hold(ways)])] = True
        return holds

    def _may_hold(self, ways: Candidates) -> NDArray[np.bool_]:
        layout = self._setting.layout
        bound = bind(ways, self._key, self._nonce)
        symbol, holds = symbols_at(ways.whole, ways.boundary, bound, layout)
        holds |= symbols_at(ways.whole, np.zeros_like(ways.boundary), bound, layout)[1]
        header = ways.kind == HEADER
        holds[header] &= symbol[header] == header_symbols(ways.index[header], self._nonce, layout.symbol)
        return np.asarray(holds & (np.abs(ways.place - ways.whole).max(axis=1) <= self._window))


def _read_as_examined(
    mesh: mm.Mesh, points: FloatArray, parts: list[tuple[Rings, RingShapes]], key: mm.Key
) -> tuple[Setting, Sweep]:
    """Read the marks as `examine` does: with the id they report, else with that of the ownership layer."""
    known = examine(mesh, key)
    rings, shapes = [group for group, _ in parts], [shape for _, shape in parts]
    for nonce in (None, known.id) if known.marked else ():
        setting = likeliest_setting(points, rings, shapes, key, nonce)
        swept = None if setting is None else sweep(points, parts, setting, key, nonce=nonce)
        if setting is not None and swept is not None and swept.nonce == known.id:
            return setting, swept
    raise mm.InputError("the model carries no marks of authentication, expected an authentic one")


def _entries(graph: csr_array, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return which of the rows (k,) each entry is of, and its column."""
    counts = np.diff(graph.indptr)[rows]
    owner = np.repeat(np.arange(len(rows)), counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, np.asarray(graph.indices[graph.indptr[rows][owner] + within], dtype=np.int64)

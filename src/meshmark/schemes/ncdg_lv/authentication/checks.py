"""Checks: which marks hold, and which points they vouch for, without any reference (DESIGN section 7)."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, log10

import numpy as np
from numpy.typing import NDArray

from meshmark.carriers.rings import Rings, ordered_rings
from meshmark.carriers.rings_shape import RingShapes, ring_shapes
from meshmark.coding.keys import Key
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
from meshmark.schemes.ncdg_lv.authentication.parameters import LAYOUTS, LEVELS, Layout
from meshmark.schemes.ncdg_lv.authentication.placement import Evidence, in_place
from meshmark.schemes.ncdg_lv.authentication.symbols import (
    directions,
    header_symbols,
    place_values,
    read_header,
)
from meshmark.schemes.ncdg_lv.authentication.words import PURPOSE, bind, symbols_at

__all__ = ["Checks", "check"]

# Points that are tried with every step, to find out which one the marks have; more where only one mark in eleven can
# be read, without the model's id.
_SAMPLE, _SAMPLE_BLIND = 600, 2500
# A ring this near (in levels) to where the level changes is tried on both sides.
_LEVEL_DOUBT = 0.1
# A point counts as covered only where its ring could have had a mark by this much.
_MARGIN = 1.1
# A mark may be this many steps from its whole place, and so many times the median of all.
_WINDOW, _WINDOWS = 0.12, 8.0
# Odd numbers that make three whole places into one.
_MIX = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)


@dataclass(frozen=True, eq=False)
class Checks:
    """What the marks say about p points.

    eligible: (p,) whose ring could have carried a mark, so that one of their closed ring does in an intact model.
    passed: (p,) whose mark holds. verified: (p,) in the closed ring of a mark that holds.
    nonce: the model's id, None where the marks do not tell. index, value, vertex: (k,) payload symbols read, and the
    points that carry them. symbol_bits: of each. step: the smallest quantiser step in scene units, 0 where none was
    found. log10_chance: bound on the chance that so many marks hold without the key.
    torn: (p,) on a boundary now, though a mark next to it says that it was not.
    """

    eligible: NDArray[np.bool_]
    passed: NDArray[np.bool_]
    verified: NDArray[np.bool_]
    nonce: int | None
    index: NDArray[np.uint32]
    value: NDArray[np.uint16]
    vertex: IntArray
    symbol_bits: int
    step: float
    log10_chance: float
    torn: NDArray[np.bool_]


@dataclass(frozen=True)
class _Setting:
    unit: float
    layout: Layout
    count: int


def check(surface: Welded, key: Key, nonce: int | None = None) -> Checks:
    """Try every point's ring for a mark of this key.

    nonce: the model's id; None: the one that the marks themselves tell.
    """
    points, faces = surface.points, surface.faces
    rings = ordered_rings(faces, len(points))
    shapes = [ring_shapes(points, group) for group in rings]
    setting = _setting(points, rings, shapes, key, nonce)
    if setting is None:
        return _nothing(len(points))
    layout = setting.layout
    subkey = key.subkey(PURPOSE)
    found = joined(
        [_all(points, group, shape, setting.unit, subkey) for group, shape in zip(rings, shapes, strict=True)]
    )
    if nonce is None:
        header = found.take(found.kind == HEADER)
        read = _held(header, bind(header, key, None), layout, None)
        nonce = read_header(header.index[read.holds], read.symbol[read.holds], layout.symbol)
        if nonce is None:
            return _nothing(len(points))
    read = _held(found, bind(found, key, nonce), layout, nonce)
    passed = np.zeros(len(points), bool)
    passed[found.vertex[read.holds]] = True
    pairs = _pairs(rings, passed)
    whole = np.zeros(len(points), bool)
    whole[found.vertex[read.holds & ~read.torn]] = True
    torn = _torn(rings, found.vertex[read.torn], whole)
    able = torn.copy()
    for group, shape in zip(rings, shapes, strict=True):
        able[group.vertex] |= eligible(shape, setting.unit, layout.levels, _MARGIN)
    place = read.holds & (found.kind == PLACE)
    evidence = Evidence(
        found.vertex[place],
        found.centre[place],
        directions(found.take(place)),
        place_values(read.symbol[place], layout.symbol),
        2.0 / (1 << layout.symbol),
    )
    passed = in_place(faces, passed, pairs, able & ~_vouched(pairs, passed), evidence)
    pairs = pairs[passed[pairs[:, 0]]]
    told = read.holds & (found.kind == PAYLOAD) & passed[found.vertex]
    told &= ~_outdone(pairs, found.vertex, np.where(read.holds, read.off, np.inf), len(points))[found.vertex]
    return Checks(
        able,
        passed,
        _vouched(pairs, passed) & ~torn,
        nonce,
        found.index[told],
        read.symbol[told].astype(np.uint16),
        found.vertex[told],
        layout.symbol,
        setting.unit,
        _log10_chance(found, read.holds, layout),
        torn,
    )


@dataclass(frozen=True, eq=False)
class _Read:
    """What candidates say: symbols (c,), whether a mark holds, how far it is off, whether its ring was torn open."""

    symbol: IntArray
    holds: NDArray[np.bool_]
    off: FloatArray
    torn: NDArray[np.bool_]


def _held(found: Candidates, bound: NDArray[np.uint64], layout: Layout, nonce: int | None) -> _Read:
    """Return which candidates are marks.

    Marks lie as near to whole places as the file's precision lets them; how near that is, the marks tell. What lies
    farther off holds by chance, or was moved by less than a step. A mark beside a boundary that would hold if there
    were none is a mark beside a hole that was made.
    """
    places = np.round(found.place)
    off = np.abs(found.place - places).max(axis=1)
    places = places.astype(np.int64)
    symbol, holds = symbols_at(places, found.rim, bound, layout)
    torn = np.zeros(len(off), bool)
    rows = np.flatnonzero((found.rim != 0) & ~holds)
    torn[rows] = symbols_at(places[rows], np.zeros(len(rows), np.int64), bound[rows], layout)[1]
    holds |= torn
    if nonce is not None:
        header = found.kind == HEADER
        holds[header] &= symbol[header] == header_symbols(found.index[header], nonce, layout.symbol)
    if holds.any():
        holds &= off <= _WINDOW + _WINDOWS * float(np.median(off[holds]))
    return _Read(symbol, holds, off, torn & holds)


def _torn(rings: list[Rings], vertex: IntArray, whole: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): the boundary points next to marks `vertex` that know of no boundary there.

    Not so where a mark whose ring is `whole` (p,) knows the boundary: then the other one holds by chance.
    """
    torn = np.zeros(len(whole), bool)
    marks = torn.copy()
    marks[vertex] = True
    for group in rings:
        own = group.take(marks[group.vertex])
        torn[own.around[own.rim]] = True
    return torn & ~_vouched(_pairs(rings, whole), whole)


def _pairs(rings: list[Rings], passed: NDArray[np.bool_]) -> IntArray:
    """Return (n, 2): each mark that holds, and each point of its ring."""
    parts = [np.empty((0, 2), np.int64)]
    for group in rings:
        own = group.take(passed[group.vertex])
        parts.append(np.stack([np.repeat(own.vertex, own.around.shape[1]), own.around.ravel()], axis=1))
    return np.concatenate(parts)


def _vouched(pairs: IntArray, passed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    verified = passed.copy()
    verified[pairs[:, 1]] = True
    return verified


def _outdone(pairs: IntArray, vertex: IntArray, off: FloatArray, count: int) -> NDArray[np.bool_]:
    """Return (p,): marks next to one that lies nearer to a whole place; of two neighbours one holds by chance."""
    best = np.full(count, np.inf)
    np.minimum.at(best, vertex, off)
    outdone = np.zeros(count, bool)
    outdone[pairs[best[pairs[:, 1]] < best[pairs[:, 0]], 0]] = True
    return outdone


def _nothing(count: int) -> Checks:
    no = np.zeros(count, bool)
    return Checks(
        no,
        no,
        no,
        None,
        np.empty(0, np.uint32),
        np.empty(0, np.uint16),
        np.empty(0, np.int64),
        0,
        0.0,
        0.0,
        no,
    )


def _all(points: FloatArray, rings: Rings, shapes: RingShapes, unit: float, subkey: bytes) -> Candidates:
    exact = level_of(shapes, unit)
    level = np.floor(exact).astype(np.int64)
    parts = []
    for change, doubtful in (
        (0, np.ones(len(exact), bool)),
        (-1, exact - level < _LEVEL_DOUBT),
        (1, exact - level > 1.0 - _LEVEL_DOUBT),
    ):
        rows = np.flatnonzero(doubtful & (level + change >= LEVELS[0]) & (level + change <= LEVELS[-1]))
        parts.append(
            candidates(
                points, rings.take(rows), shapes.take(rows), level[rows] + change, subkey, all_ways=True
            )
        )
    return joined(parts)


def _setting(
    points: FloatArray, rings: list[Rings], shapes: list[RingShapes], key: Key, nonce: int | None
) -> _Setting | None:
    """Return the step and layout under which most marks of a sample hold."""
    total = sum(len(group.vertex) for group in rings)
    every = max(total // (_SAMPLE_BLIND if nonce is None else _SAMPLE), 1)
    subkey = key.subkey(PURPOSE)
    parts = []
    for group, shape in zip(rings, shapes, strict=True):
        rows = np.arange(0, len(group.vertex), every)
        few, shaped = group.take(rows), shape.take(rows)
        for level in LEVELS:
            ways = candidates(points, few, shaped, np.full(len(rows), level), subkey, all_ways=False)
            parts.append((level_of(shaped, 1.0) - level, ways))
    if not parts:
        return None
    size = np.concatenate([part[0] for part in parts])
    found = joined([part[1] for part in parts])
    if nonce is None:
        size, found = size[found.kind == HEADER], found.take(found.kind == HEADER)
    bound = bind(found, key, nonce)
    places = np.round(found.place).astype(np.int64)
    best = None
    for layout in LAYOUTS.values():
        _, holds = symbols_at(places, found.rim, bound, layout)
        start, count = _densest(np.sort(size[holds]))
        if best is None or count > best[2]:
            best = (start, layout, count)
    if best is None or best[2] == 0:
        return None
    return _Setting(2.0 ** (best[0] / 2.0), best[1], best[2])


def _densest(values: FloatArray) -> tuple[float, int]:
    """Return the start of the interval of length 1 that holds most of the sorted values, and how many."""
    if not len(values):
        return 0.0, 0
    counts = np.searchsorted(values, values + 1.0) - np.arange(len(values))
    best = int(counts.argmax())
    # The interval may start anywhere between its last value less 1 and its first.
    return float((values[best] + values[best + counts[best] - 1] - 1.0) / 2.0), int(counts[best])


def _log10_chance(found: Candidates, holds: NDArray[np.bool_], layout: Layout) -> float:
    """Bound the chance that so many marks hold by luck, times all layouts and levels (Chernoff).

    Points that lie alike in rings that are alike count once: their marks hold or fail together.
    """
    cells = np.round(found.place).astype(np.int64).view(np.uint64) @ _MIX
    tries = found.words[:, 0] ^ cells
    total, held = len(np.unique(tries)), len(np.unique(tries[holds]))
    luck = 2.0**-layout.check
    share = held / max(total, 1)
    if share <= luck:
        return 0.0
    rest = 0.0 if share >= 1.0 else (1.0 - share) * log((1.0 - share) / (1.0 - luck))
    nats = total * (share * log(share / luck) + rest)
    return min(0.0, log10(len(LAYOUTS) * len(LEVELS)) - nats / log(10.0))

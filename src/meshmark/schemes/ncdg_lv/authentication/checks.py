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
    Candidates,
    candidates,
    eligible,
    joined,
    level_of,
)
from meshmark.schemes.ncdg_lv.authentication.parameters import LAYOUTS, LEVELS, Layout
from meshmark.schemes.ncdg_lv.authentication.symbols import read_header
from meshmark.schemes.ncdg_lv.authentication.words import PURPOSE, bind, symbols_at

__all__ = ["Checks", "check"]

# Points that are tried with every step, to find out which one the marks have.
_SAMPLE = 3000
# A ring this near (in levels) to where the level changes is tried on both sides.
_LEVEL_DOUBT = 0.1
_MARGIN = 1.1


@dataclass(frozen=True, eq=False)
class Checks:
    """What the marks say about p points.

    eligible: (p,) whose ring could have carried a mark, so that one of their closed ring does in an intact model.
    passed: (p,) whose mark holds. verified: (p,) in the closed ring of a mark that holds.
    nonce: the model's id, None where the marks do not tell. index, value, vertex: (k,) payload symbols read, and the
    points that carry them. symbol_bits: of each. step: the smallest quantiser step in scene units, 0 where none was
    found. log10_chance: bound on the chance that so many marks hold without the key.
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
    subkey = key.subkey(PURPOSE)
    found = joined(
        [_all(points, group, shape, setting.unit, subkey) for group, shape in zip(rings, shapes, strict=True)]
    )
    places = np.round(found.place).astype(np.int64)
    if nonce is None:
        header = found.kind == HEADER
        symbol, holds = symbols_at(places[header], bind(found.take(header), key, None), setting.layout)
        nonce = read_header(found.index[header][holds], symbol[holds], setting.layout.symbol)
        if nonce is None:
            return _nothing(len(points))
    symbol, holds = symbols_at(places, bind(found, key, nonce), setting.layout)
    passed = np.zeros(len(points), bool)
    passed[found.vertex[holds]] = True
    verified = passed.copy()
    able = np.zeros(len(points), bool)
    for group, shape in zip(rings, shapes, strict=True):
        verified[group.around[passed[group.vertex]]] = True
        able[group.vertex] = eligible(shape, setting.unit, setting.layout.levels, _MARGIN)
    read = holds & (found.kind == PAYLOAD)
    return Checks(
        able,
        passed,
        verified,
        nonce,
        found.index[read],
        symbol[read].astype(np.uint16),
        found.vertex[read],
        setting.layout.symbol,
        setting.unit,
        _log10_chance(int(holds.sum()), len(holds), setting.layout),
    )


def _nothing(count: int) -> Checks:
    no = np.zeros(count, bool)
    return Checks(
        no, no, no, None, np.empty(0, np.uint32), np.empty(0, np.uint16), np.empty(0, np.int64), 0, 0.0, 0.0
    )


def _all(points: FloatArray, rings: Rings, shapes: RingShapes, unit: float, subkey: bytes) -> Candidates:
    exact = level_of(shapes.size, unit)
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
    every = max(total // _SAMPLE, 1)
    subkey = key.subkey(PURPOSE)
    parts = []
    for group, shape in zip(rings, shapes, strict=True):
        rows = np.arange(0, len(group.vertex), every)
        few, shaped = group.take(rows), shape.take(rows)
        for level in LEVELS:
            ways = candidates(points, few, shaped, np.full(len(rows), level), subkey, all_ways=False)
            parts.append((2.0 * np.log2(np.maximum(shaped.size, 1e-300)) - level, ways))
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
        _, holds = symbols_at(places, bound, layout)
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


def _log10_chance(holds: int, tries: int, layout: Layout) -> float:
    """Bound the chance that so many of `tries` hold by luck, times all layouts and levels (Chernoff)."""
    luck = 2.0**-layout.check
    share = holds / max(tries, 1)
    if share <= luck:
        return 0.0
    rest = 0.0 if share >= 1.0 else (1.0 - share) * log((1.0 - share) / (1.0 - luck))
    nats = tries * (share * log(share / luck) + rest)
    return min(0.0, log10(len(LAYOUTS) * len(LEVELS)) - nats / log(10.0))

"""Checks: which marks hold, and which points they vouch for, without any reference (docs/design.md, section 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.in_place import Evidence, Scale, in_place
from meshmark.authentication.checks.ring_reading import chance_of
from meshmark.authentication.checks.setting_search import likeliest_setting
from meshmark.authentication.checks.sweep import sweep
from meshmark.authentication.marks.candidates import (
    PAYLOAD,
    PLACE,
)
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.symbols import (
    directions,
    place_values,
)
from meshmark.authentication.payload.payload import SymbolSource
from meshmark.coding.keys import Key
from meshmark.geometry.shown import Shown
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Checks", "check"]

# A mark of a copy lies where its original does if it is off by at most this number of the smallest steps.
_COINCIDENT = 8.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Checks:
    """What the marks say about p points.

    eligible: (p,) whose ring could have carried a mark, so that one of their closed ring does in an intact
    model. passed: (p,) whose mark holds. verified: (p,) in the closed ring of a mark that holds. nonce: the
    model's id, None where the marks do not report one. index, value, vertex: (k,) payload symbols read, and the
    points that carry them. symbol_bits: of each. step: that of a ring of spread 1, in scene units, as estimated
    from the marks, 0 where there are none. log10_chance: bound on the chance that as many marks hold without the
    key. new_boundary: (p,) on a boundary now, though a mark next to it says that it was not. scale: of the marked
    model.
    held_index, held_value, held_vertex: (s,) payload symbols of all marks that hold, also of those which the map
    rejects; more of them are wrong.
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
    new_boundary: NDArray[np.bool_]
    scale: Scale
    held_index: NDArray[np.uint32]
    held_value: NDArray[np.uint16]
    held_vertex: IntArray


def check(
    surface: Surface, key: Key, nonce: int | None = None, payload: SymbolSource | None = None
) -> Checks:
    """Read every point's ring as a mark of this key.

    nonce: the model's id; None: the one that the marks report. payload: the expected symbols, where they have been
    decoded; a mark that says another one does not hold.
    """
    points = surface.points
    rings = rings_of(surface)
    shapes = [ring_shapes(points, group) for group in rings]
    setting = likeliest_setting(points, rings, shapes, key, nonce)
    if setting is None:
        return _nothing(len(points))
    layout = setting.layout
    swept = sweep(points, list(zip(rings, shapes, strict=True)), setting, key, nonce=nonce, payload=payload)
    if swept is None:
        return _nothing(len(points))
    found, read = swept.found, swept.read
    passed = np.zeros(len(points), bool)
    passed[found.vertex[read.holds]] = True
    pairs = _pairs(rings, passed)
    whole = np.zeros(len(points), bool)
    whole[found.vertex[read.holds & ~read.new_boundary]] = True
    new_boundary = _new_boundary(rings, found.vertex[read.new_boundary], whole, 2 if swept.rounded else 1)
    able = swept.able | new_boundary
    outdone = _outdone(pairs, found.vertex, np.where(read.holds, read.off, np.inf), len(points))
    place = read.holds & (found.kind == PLACE) & ~outdone[found.vertex]
    evidence = Evidence(
        vertex=found.vertex[place],
        centre=found.centre[place],
        direction=directions(found.take(place)),
        value=place_values(read.symbol[place], layout.symbol),
        step=2.0 / (1 << layout.symbol),
    )
    linked = np.concatenate([pairs, _copied(surface, passed, setting.unit)])
    passed, scale = in_place(
        surface.edges,
        passed,
        linked,
        able & ~_vouched(pairs, passed),
        evidence,
        lucky=int(swept.rounded),
    )
    pairs = pairs[passed[pairs[:, 0]]]
    held = read.holds & (found.kind == PAYLOAD)
    decoded = held & passed[found.vertex]
    decoded &= ~_outdone(pairs, found.vertex, np.where(read.holds, read.off, np.inf), len(points))[
        found.vertex
    ]
    return Checks(
        eligible=able,
        passed=passed,
        verified=_vouched(pairs, passed) & ~new_boundary,
        nonce=swept.nonce,
        index=found.index[decoded],
        value=read.symbol[decoded].astype(np.uint16),
        vertex=found.vertex[decoded],
        symbol_bits=layout.symbol,
        step=setting.unit,
        log10_chance=chance_of(found, read.holds, layout),
        new_boundary=new_boundary,
        scale=scale,
        held_index=found.index[held],
        held_value=read.symbol[held].astype(np.uint16),
        held_vertex=found.vertex[held],
    )


def _copied(surface: Surface, passed: NDArray[np.bool_], unit: float) -> IntArray:
    """Return (n, 2): each mark of a copy that holds and lies where that of the original does, which holds, too."""
    if not isinstance(surface, Shown):
        return np.empty((0, 2), np.int64)
    copy = np.flatnonzero(passed & passed[surface.original])
    off = np.linalg.norm(surface.points[copy] - surface.points[surface.original[copy]], axis=1)
    copy = copy[off <= _COINCIDENT * unit]
    return np.stack([copy, surface.original[copy]], axis=1)


def _new_boundary(
    rings: list[Rings], vertex: IntArray, whole: NDArray[np.bool_], least: int
) -> NDArray[np.bool_]:
    """Return (p,): the boundary points next to `least` or more marks `vertex` that know of no boundary there.

    Not so where a mark whose ring is `whole` (p,) knows the boundary: then the other one holds by chance. In a
    rounded file, where the window is wide, one alone may; and where it lies next to a whole mark it does, as no two
    marks are neighbours.
    """
    count = np.zeros(len(whole), np.int64)
    marks = np.zeros(len(whole), bool)
    marks[vertex] = True
    pairs = _pairs(rings, whole)
    marks[pairs[:, 1]] = False
    for group in rings:
        own = group.take(marks[group.vertex])
        np.add.at(count, own.around[own.boundary], 1)
    found = count >= least
    return found & ~_vouched(pairs, whole)


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
        eligible=no,
        passed=no,
        verified=no,
        nonce=None,
        index=np.empty(0, np.uint32),
        value=np.empty(0, np.uint16),
        vertex=np.empty(0, np.int64),
        symbol_bits=0,
        step=0.0,
        log10_chance=0.0,
        new_boundary=no,
        scale=Scale(),
        held_index=np.empty(0, np.uint32),
        held_value=np.empty(0, np.uint16),
        held_vertex=np.empty(0, np.int64),
    )

"""Checks: which marks hold, and which points they vouch for, without any reference (docs/design.md, section 7)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray, FloatArray, IntArray
from meshmark.authentication.checks.carried import Carried, Expected, carried
from meshmark.authentication.checks.in_place import in_place
from meshmark.authentication.checks.model_frame import ModelFrame, Scale, evidence_of
from meshmark.authentication.checks.ring_reading import chance_of
from meshmark.authentication.checks.setting_search import likeliest_setting
from meshmark.authentication.checks.sweep import Sweep, sweep
from meshmark.authentication.marks.candidates import HEADER, PAYLOAD, PLACE, Candidates
from meshmark.authentication.marks.ring_shapes import RingShapes, in_style, ring_shapes
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.signed_word import signed_points, signed_word
from meshmark.authentication.parameters import Layout
from meshmark.coding.keys import Key
from meshmark.geometry.components import connected_parts
from meshmark.geometry.shown import Shown
from meshmark.geometry.surface import Surface

__all__ = ["Checks", "check", "shapes_of"]

# A mark of a copy lies where its original does if it is off by at most this number of the smallest steps.
_COINCIDENT = 8.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Checks:
    """What the marks say about p points.

    eligible: (p,) whose ring could have carried a mark, so that one of their closed ring does in an intact
    model. passed: (p,) whose mark holds. verified: (p,) in the closed ring of a mark that holds. nonce: the
    model's id, None where the marks do not report one. carried: payload symbols of the marks that are believed;
    held: those of all marks that hold, also of those which the map rejects; more of them are wrong. symbol_bits: of
    each. step: that of a ring of spread 1, in scene units, as estimated from the marks, 0 where there are none;
    error: of a coordinate, that they were made for. log10_chance: bound on the chance that as many marks hold
    without the key. new_boundary: (p,) on a boundary now, though a mark next to it says that it was not. frame: of
    the marked model, None where it is not known. repeated: two marks that tell the id hold in rings that are alike,
    in different places. requantised: the marks bear a grid of 14 bits, and the coordinates were rounded about as
    coarsely. speak: the marks are evidence, as a model's id is known or they are those of a small model.
    signed: of a small model whose id is known, how many points it was marked with, 0 where they were not counted.
    elsewhere: (p,) marks that hold, but lie where they were not made: those of parts that were moved as one, or
    pasted.
    """

    eligible: NDArray[np.bool_]
    passed: NDArray[np.bool_]
    verified: NDArray[np.bool_]
    elsewhere: NDArray[np.bool_]
    nonce: int | None
    carried: Carried
    held: Carried
    symbol_bits: int
    step: float
    error: float
    log10_chance: float
    new_boundary: NDArray[np.bool_]
    frame: ModelFrame | None
    repeated: bool
    requantised: bool = False
    speak: bool = False
    signed: int | None = None

    @property
    def scale(self) -> Scale:
        """Return the scale of the marked model in the suspect's scene."""
        return Scale() if self.frame is None else self.frame.scale


def shapes_of(surface: Surface) -> list[RingShapes]:
    """Return the shapes of a surface's rings, which several checks of it share."""
    return [ring_shapes(surface.points, group) for group in rings_of(surface)]


def check(
    surface: Surface,
    key: Key,
    nonce: int | None = None,
    payload: Expected | None = None,
    *,
    shapes: list[RingShapes] | None = None,
) -> Checks:
    """Read every point's ring as a mark of this key.

    nonce: the model's id; None: the one that the marks report. payload: what the marks should say, where it has
    been decoded; a mark that says anything else does not hold. shapes: those of `shapes_of`, where they are there.
    """
    points = surface.points
    rings = rings_of(surface)
    shapes = shapes_of(surface) if shapes is None else shapes
    setting = likeliest_setting(points, rings, shapes, key, nonce)
    if setting is None:
        return _nothing(len(points))
    layout = setting.layout
    shapes = [in_style(shape, setting.style) for shape in shapes]
    parts = list(zip(rings, shapes, strict=True))
    signed = None
    if layout.pieces_only:
        swept = sweep(points, parts, setting, key, nonce=None)
        if swept is not None and nonce is not None:
            signed = _signed(surface, swept, key, nonce, layout)
            word = None if signed is None else signed_word(key, nonce, signed)
            swept = None if word is None else sweep(points, parts, setting, key, nonce=word)
    else:
        swept = sweep(points, parts, setting, key, nonce=nonce, payload=payload)
    if swept is None:
        return _nothing(len(points))
    found, read = swept.found, swept.read
    repeated = _repeated(surface, found, read.holds)
    if payload is not None and payload.once:
        read = replace(read, holds=read.holds & ~repeated)
    passed = np.zeros(len(points), bool)
    passed[found.vertex[read.holds]] = True
    pairs = _pairs(rings, passed)
    whole = np.zeros(len(points), bool)
    whole[found.vertex[read.holds & ~read.new_boundary]] = True
    new_boundary = _new_boundary(rings, found.vertex[read.new_boundary], whole, 2 if swept.rounded else 1)
    requantised = swept.rounded and not setting.style.pull
    if requantised:
        new_boundary = _torn(surface, rings, found.vertex[read.new_boundary], whole)
    able = swept.able | new_boundary
    outdone = _outdone(pairs, found.vertex, np.where(read.holds, read.off, np.inf), len(points))
    place = read.holds & (found.kind == PLACE) & ~outdone[found.vertex]
    evidence = evidence_of(found.take(place), read.symbol[place], layout.symbol, setting.error)
    linked = np.concatenate([pairs, _copied(surface, passed, setting.unit)])
    placed = in_place(
        surface.edges,
        passed,
        linked,
        able & ~_vouched(pairs, passed),
        evidence,
        lucky=int(swept.rounded),
    )
    elsewhere = passed & ~placed.believed
    passed = placed.believed
    pairs = pairs[passed[pairs[:, 0]]]
    held = read.holds & (found.kind == PAYLOAD)
    decoded = held & passed[found.vertex]
    decoded &= ~_outdone(pairs, found.vertex, np.where(read.holds, read.off, np.inf), len(points))[
        found.vertex
    ]
    plain = _read_one_way(swept)[found.vertex]
    return Checks(
        eligible=able,
        passed=passed,
        verified=_vouched(pairs, passed) & ~new_boundary,
        elsewhere=elsewhere,
        nonce=nonce if layout.pieces_only else swept.nonce,
        signed=signed,
        carried=carried(found.take(decoded), read.symbol[decoded], plain[decoded]),
        held=carried(found.take(held), read.symbol[held]),
        symbol_bits=layout.symbol,
        step=setting.unit,
        error=setting.error,
        log10_chance=chance_of(found, read.holds, layout, swept.unread),
        new_boundary=new_boundary,
        frame=placed.frame,
        repeated=bool(repeated.any()),
        requantised=requantised,
        speak=swept.nonce is not None or layout.pieces_only,
    )


def _read_one_way(swept: Sweep) -> NDArray[np.bool_]:
    """Return, for each point up to the last that is read: whether there was one way to read it."""
    ways = np.bincount(swept.found.vertex)
    if swept.unread is not None:
        ways += np.bincount(swept.found.vertex[swept.unread.row], minlength=len(ways))
    return np.asarray(ways == 1)


def _signed(surface: Surface, swept: Sweep, key: Key, nonce: int, layout: Layout) -> int | None:
    """Return how many points a small model of this id was marked with, None where its marks are another's."""
    rows = np.flatnonzero(swept.read.holds)
    index, symbol = swept.found.index[rows], swept.read.symbol[rows]
    return signed_points(index, symbol, layout.symbol, key, nonce, now=int(surface.used.sum()))


def _repeated(surface: Surface, found: Candidates, holds: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (c,): which marks that tell the id hold at several points in rings that are alike; a copy is none."""
    repeated = np.zeros(len(holds), bool)
    rows = np.flatnonzero(holds & (found.kind == HEADER))
    point = found.vertex[rows].astype(np.int64)
    point = surface.original[point] if isinstance(surface, Shown) else point
    pairs, place = np.unique(
        np.stack([found.name[rows], point.astype(np.uint64)], axis=1), axis=0, return_inverse=True
    )
    _, ring, times = np.unique(pairs[:, 0], return_inverse=True, return_counts=True)
    repeated[rows] = (times[ring] > 1)[place.reshape(-1)]
    return repeated


def _copied(surface: Surface, passed: NDArray[np.bool_], unit: float) -> IntArray:
    """Return (n, 2): each mark of a copy that holds and lies where that of the original does, which holds, too."""
    if not isinstance(surface, Shown):
        return np.empty((0, 2), np.int64)
    copy = np.flatnonzero(passed & passed[surface.original])
    off = np.linalg.norm(surface.points[copy] - surface.points[surface.original[copy]], axis=1)
    copy = copy[off <= _COINCIDENT * unit]
    return np.stack([copy, surface.original[copy]], axis=1)


def _new_boundary(
    rings: list[Rings], vertex: AnyIntArray, whole: NDArray[np.bool_], least: int
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


def _torn(
    surface: Surface, rings: list[Rings], vertex: AnyIntArray, whole: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return (p,): the boundary points of `_new_boundary` near which are those of another mark, too.

    In a requantised file few marks see a rim at all, mostly one each of its points; by chance single ones do.
    """
    found = _new_boundary(rings, vertex, whole, 1)
    if not found.any():
        return found
    part = connected_parts(surface.graph, found | (surface.graph @ found.astype(np.float64) > 0.0))
    marks = np.zeros(len(found), bool)
    marks[vertex] = True
    pairs = _pairs(rings, marks)
    pairs = pairs[found[pairs[:, 1]]]
    pairs = np.unique(np.stack([pairs[:, 0], part[pairs[:, 1]]], axis=1), axis=0)
    count = np.bincount(pairs[:, 1], minlength=int(part.max()) + 1)
    return np.asarray(found & (count[part] >= 2))


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


def _outdone(pairs: IntArray, vertex: AnyIntArray, off: FloatArray, count: int) -> NDArray[np.bool_]:
    """Return (p,): marks next to one that lies nearer to a whole place; of two neighbours one holds by chance."""
    best = np.full(count, np.inf)
    np.minimum.at(best, vertex, off)
    outdone = np.zeros(count, bool)
    outdone[pairs[best[pairs[:, 1]] < best[pairs[:, 0]], 0]] = True
    return outdone


def _nothing(count: int) -> Checks:
    no = np.zeros(count, bool)
    none = Carried(
        index=np.empty(0, np.uint32),
        value=np.empty(0, np.uint16),
        vertex=np.empty(0, np.int64),
        ring=np.empty(0, np.uint64),
        centre=np.empty((0, 3)),
        plain=no[:0],
    )
    return Checks(
        eligible=no,
        passed=no,
        verified=no,
        elsewhere=no,
        nonce=None,
        carried=none,
        held=none,
        symbol_bits=0,
        step=0.0,
        error=0.0,
        log10_chance=0.0,
        new_boundary=no,
        frame=None,
        repeated=False,
    )

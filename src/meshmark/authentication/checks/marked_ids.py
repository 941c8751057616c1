"""The ids that the marks of a surface report, one after another, and which part of it those of each vouch for.

Marks are local: each says something by its own ring. So a surface that was put together of marked ones has marks
of several ids. The likeliest id is read first, then what is left without its part, as long as enough is left. All
of it is tried as one, then its connected components, and where neither gives an id halves and eighths of the box
about it: there most marks may be of one id.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import log10
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.likeliest_id import likeliest_id
from meshmark.authentication.checks.ring_reading import beyond_luck, chance_of, read_marks
from meshmark.authentication.checks.setting_search import Setting, likeliest_setting, plain_candidates
from meshmark.authentication.checks.sweep import able_rings, sweep, vouched
from meshmark.authentication.marks.candidates import HEADER, Candidates, joined
from meshmark.authentication.marks.ring_shapes import RingShapes, in_style, ring_shapes
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.words import PURPOSE
from meshmark.authentication.parameters import MARKED_LOG10, TRIED_IDS
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.large_components import MOST_READ, large_components

__all__ = ["MarkedId", "marked_ids"]

# Ids that are read of one surface at most.
_MOST_IDS = 8
# Ids that are tried where pieces of an id are missing: of all that is left, and of a part of it.
_TRIED, _FEWER_IDS = 1 << 16, 1 << 10
# Fewer points than this do not carry an id; what is left is read where it is also this share of all.
_LEAST, _WORTH_READING = 150, 0.02
# Rounds in which marks are averaged over neighbours, and the share of the typical density of an id's marks, at the
# median of them, from which on a point is in their part. Marks that hold by luck are thinner.
_ROUNDS, _DENSE = 6, 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class MarkedId:
    """One id and its marks.

    id: of 64 bits. log10_chance: bound on the chance that as many marks hold without the key, over all that was
    tried. points: (p,) which points its marks vouch for.
    """

    id: int
    log10_chance: float
    points: NDArray[np.bool_]


def marked_ids(surface: Surface, key: Key) -> tuple[MarkedId, ...]:
    """Return the ids of which marks of a key are surely there, that with the largest part first.

    The bound of each is Chernoff's of the marks that carry no piece of an id, on the region where it was read: what
    they say depends on the id, so that pieces of several ids, mixed, prove nothing. It is multiplied by the ways to
    read marks, by the ids that were tried, and by t (t + 1) where this was the t-th region that was read.

    Parameters
    ----------
    surface : Surface
        Of p points.
    key : Key

    Returns
    -------
    tuple of MarkedId
        Empty where none are there, and of small models, whose marks do not report their id.

    References
    ----------
    Chernoff (1952), doi:10.1214/aoms/1177729330.
    """
    reader = _Reader(surface, key)
    left = np.asarray(surface.used)
    while len(reader.found) < _MOST_IDS and reader.read(left):
        left = left & ~reader.taken
        if not reader.worth_reading(left):
            return reader.merged()
    for part in large_components(surface, MOST_READ, left):
        reader.read(part, likely_only=True)
    return reader.merged()


_Some = TypeVar("_Some", Rings, RingShapes)


class _Reader:
    """Reads regions of one surface, and keeps what was found, the points that are done with, and the count of
    regions.
    """

    def __init__(self, surface: Surface, key: Key) -> None:
        self.surface, self.key = surface, key
        self.rings = rings_of(surface)
        self.found: list[MarkedId] = []
        self.taken = np.zeros(len(surface.points), bool)
        self.able = np.asarray(surface.used)
        self._regions = 0

    @cached_property
    def shapes(self) -> list[RingShapes]:
        """Of the rings; an unmarked surface, of which a sample is read, does not need all of them."""
        return [ring_shapes(self.surface.points, group) for group in self.rings]

    def worth_reading(self, left: NDArray[np.bool_]) -> bool:
        """Return whether enough points (p,) that could carry marks are left for another id."""
        return int((left & self.able).sum()) >= max(_LEAST, _WORTH_READING * int(self.able.sum()))

    def merged(self) -> tuple[MarkedId, ...]:
        """Return what was found, each id once, that with the largest part first."""
        by_id: dict[int, MarkedId] = {}
        for each in self.found:
            known = by_id.get(each.id, each)
            points = known.points | each.points
            chance = min(known.log10_chance, each.log10_chance)
            by_id[each.id] = MarkedId(id=each.id, log10_chance=chance, points=points)
        areas = self.surface.point_shares
        return tuple(sorted(by_id.values(), key=lambda each: -float(areas[each.points].sum())))

    def read(self, chosen: NDArray[np.bool_], *, likely_only: bool = False) -> bool:
        """Read all ids of the chosen points (p,) under the likeliest setting; return whether there is any."""
        rows = [np.flatnonzero(chosen[group.vertex]) for group in self.rings]
        rings = [_taken(group, some) for group, some in zip(self.rings, rows, strict=True) if len(some)]
        setting = likeliest_setting(self.surface.points, rings, None, self.key, None, likely_only=likely_only)
        if setting is None or setting.layout.pieces_only:
            return False
        shapes = [_taken(shape, some) for shape, some in zip(self.shapes, rows, strict=True) if len(some)]
        parts = [(group, in_style(shape, setting.style)) for group, shape in zip(rings, shapes, strict=True)]
        able = np.zeros(len(chosen), bool)
        for group, shape in parts:
            able[group.vertex] = able_rings(shape, setting)
        self.able = np.where(chosen, able, self.able)
        found = self._plain(parts, setting)
        before, swept = len(self.found), None
        while len(self.found) < _MOST_IDS and (swept is not None or self._may_be_marked(found, setting)):
            one = self._one(found, setting, parts)
            if one is None and len(self.found) == before and swept is None:
                swept = sweep(self.surface.points, parts, setting, self.key, nonce=None)
                found = found if swept is None else swept.all_tries
                one = None if swept is None else self._one(found, setting, parts)
            if one is None:
                break
            self.found.append(one)
            found = found.take(~self.taken[found.vertex])
            if not self.worth_reading(chosen & ~self.taken):
                break
        return len(self.found) > before

    def _plain(self, parts: list[tuple[Rings, RingShapes]], setting: Setting) -> Candidates:
        subkey = self.key.subkey(PURPOSE)
        return joined(plain_candidates(self.surface.points, *part, setting, subkey) for part in parts)

    def _may_be_marked(self, found: Candidates, setting: Setting) -> bool:
        """Return whether more marks that tell an id hold than by luck."""
        header = found.take(found.kind == HEADER)
        read = read_marks(header, self.key, setting.layout, None)
        return beyond_luck(header, read.holds, setting.layout)

    def _one(
        self, found: Candidates, setting: Setting, parts: list[tuple[Rings, RingShapes]]
    ) -> MarkedId | None:
        """Return the id that the first region has which reports one surely, and take its part from what is left."""
        for number, region in enumerate(_regions(found.centre, self._components_of(found))):
            some = found.take(region)
            self._regions += 1
            most = _FEWER_IDS if number else _TRIED
            identity, tried = likeliest_id(some, self.key, setting.layout, most)
            if identity is None:
                continue
            rest = some.take(some.kind != HEADER)
            read = read_marks(rest, self.key, setting.layout, identity)
            chance = chance_of(rest, read.holds, setting.layout)
            chance += log10(self._regions * (self._regions + 1) * max(tried / TRIED_IDS, 1.0))
            if chance > MARKED_LOG10:
                continue
            return replace(self._part_of(identity, found, setting, parts), log10_chance=min(chance, 0.0))
        return None

    def _components_of(self, found: Candidates) -> list[NDArray[np.bool_]]:
        """Return rows (c,) of candidates in each large component, none where there is one component only."""
        chosen = np.zeros(len(self.taken), bool)
        chosen[found.vertex] = True
        return [part[found.vertex] for part in large_components(self.surface, MOST_READ, chosen)]

    def _part_of(
        self, identity: int, found: Candidates, setting: Setting, parts: list[tuple[Rings, RingShapes]]
    ) -> MarkedId:
        """Return the id with the points that its marks vouch for, and take the part in which they are dense."""
        read = read_marks(found, self.key, setting.layout, identity)
        held, whole = np.zeros(len(self.taken), bool), np.zeros(len(self.taken), bool)
        held[found.vertex[read.holds]] = True
        whole[found.vertex[read.holds & ~read.new_boundary]] = True
        home = self._dense(held)
        self.taken = self.taken | home
        return MarkedId(id=identity, log10_chance=0.0, points=vouched(parts, whole & home) & home)

    def _dense(self, held: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return (p,): where marks that hold (p,) are about as dense as at most of them."""
        graph = self.surface.graph
        degree = np.asarray(graph.sum(axis=1)).ravel() + 1.0
        marks, able = held.astype(np.float64), (self.able | held).astype(np.float64)
        for _ in range(_ROUNDS):
            marks, able = (graph @ marks + marks) / degree, (graph @ able + able) / degree
        density = marks / np.maximum(able, 1e-9)
        return np.asarray((marks > 0.0) & (density >= _DENSE * float(np.median(density[held]))))


def _taken(whole: _Some, rows: IntArray) -> _Some:
    """Return some rows; where they are all, as at first, no second one of everything."""
    return whole if len(rows) == len(whole.around) else whole.take(rows)


def _regions(centre: FloatArray, components: list[NDArray[np.bool_]]) -> Iterator[NDArray[np.bool_]]:
    """Yield rows (c,): all, components, and halves and eighths along the principal axes of `centre` (c, 3)."""
    yield np.ones(len(centre), bool)
    yield from components
    middle = centre - centre.mean(axis=0)
    axes = np.linalg.eigh(middle.T @ middle)[1].T[::-1]
    above = [middle @ axis >= np.median(middle @ axis) for axis in axes]
    for side in above:
        yield side
        yield ~side
    for signs in product((True, False), repeat=3):
        yield np.logical_and.reduce([side == sign for side, sign in zip(above, signs, strict=True)])

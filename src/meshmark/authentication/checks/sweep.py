"""The sweep over all rings: the plain reading of each, then every other one where no mark vouches for a point."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.carried import Expected
from meshmark.authentication.checks.likeliest_id import marks_of_ids
from meshmark.authentication.checks.ring_reading import Read, beyond_luck, read_marks
from meshmark.authentication.checks.setting_search import Setting, all_candidates, plain_ways
from meshmark.authentication.marks.candidates import (
    HEADER,
    Beside,
    Candidates,
    as_laid_out,
    beside,
    eligible,
    joined,
    level_of,
    placed,
    with_beside,
)
from meshmark.authentication.marks.ring_shapes import RingShapes
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.symbols import read_header
from meshmark.authentication.marks.words import PURPOSE
from meshmark.coding.keys import Key
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray

__all__ = ["NEAR", "ROUNDED", "Sweep", "able_rings", "sweep", "vouched"]

# A point counts as covered only where its ring could have had a mark by this much.
_MARGIN = 1.1
# Where marks are so far off their whole places at the median, in steps, the file was rounded to few digits. Then
# the next whole places are tried, too, of marks that are at least this far off.
ROUNDED, NEAR = 0.03, 0.15
# Marks beside those that tell the id on which each likely one is tried.
_SAMPLE = 600
# One in this number of these tells most of the wrong ids: those that have less than half as many marks as the best
# one, by this number, which may hold by luck.
_SCREENED, _BY_LUCK = 6, 3
# Rings whose candidates are made at once: a large model's would take gigabytes meanwhile.
_BLOCK = 1 << 16
# Where this number of marks is read and no more hold than by luck, other ways to read them are not tried.
_MANY = 1000
_Parts = list[tuple[Rings, RingShapes]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Sweep:
    """found: (c,) the candidates tried; read: what they say; nonce: the model's id, given or reported, or None.

    able: (p,) points whose ring could carry a mark. rounded: the file was rounded to few digits. unread: whole
    places besides that count as tries, at none of which a mark holds.
    """

    found: Candidates
    read: Read
    nonce: int | None
    able: NDArray[np.bool_]
    rounded: bool
    unread: Beside | None = None

    @property
    def all_tries(self) -> Candidates:
        """Return all candidates that count as tries."""
        return self.found if self.unread is None else with_beside(self.found, self.unread)


def sweep(
    points: FloatArray,
    parts: _Parts,
    setting: Setting,
    key: Key,
    *,
    nonce: int | None,
    payload: Expected | None = None,
) -> Sweep | None:
    """Return what the rings of points (p, 3) say, None where no model's id is given or reported but is needed.

    A mark's plain reading may be off where a length was rounded across a boundary: then its ring has no voucher.
    So all ways are tried for points without a voucher and for those next to them, which are few in an intact model.
    In a file of few digits their next whole places are tried as well. nonce: what marks are bound to; those of
    small models are read without it, too, but report none. payload: see `read_marks`.
    """
    subkey = key.subkey(PURPOSE)
    plain = [each for part in parts for each in plain_ways(*part, setting, subkey)]
    blind = nonce is None and not setting.layout.pieces_only
    if blind:  # most surfaces have no marks, which a tenth of the readings shows
        header = joined(placed(points, each.of_kind(HEADER)) for each in plain)
        if _surely_none(header, read_marks(header, key, setting.layout, None), setting):
            return None
    # One after another, as each takes much room.
    found = as_laid_out(joined(placed(points, plain.pop(0)) for _ in range(len(plain))), setting.layout)
    able, held = np.zeros((2, len(points)), bool)
    for group, shape in parts:
        able[group.vertex] = able_rings(shape, setting)
    identity, none = _reported_id(found, key, setting) if blind else nonce, False
    readable = identity is not None or not blind
    if readable:
        read = read_marks(found, key, setting.layout, identity, payload)
        held[found.vertex[read.holds & ~read.new_boundary]] = True
        none = _surely_none(found, read, setting)
    again = _around(parts, able & ~vouched(parts, held))
    if not readable or (again.any() and not none):
        found = found.take(~again[found.vertex])
        found = joined(chain([found], _all(points, parts, again, setting, subkey)))
        if blind:
            identity = _reported_id(found, key, setting)
        if blind and identity is None:
            return None
        read = read_marks(found, key, setting.layout, identity, payload)
    unread: Beside | None = None
    rounded = bool(read.holds.any() and np.median(read.off[read.holds]) > ROUNDED)
    if rounded:
        held[:] = False
        held[found.vertex[read.holds & ~read.new_boundary]] = True
        again = _around(parts, able & ~vouched(parts, held))
        first, tries = len(found.vertex), beside(found, again[found.vertex], NEAR)
        read = read_marks(found, key, setting.layout, identity, payload, more=tries)
        holds = read.holds & ~(read.new_boundary & (np.arange(len(read.holds)) >= first))
        # So many tries would make holes by chance.
        read = replace(read, holds=holds, new_boundary=read.new_boundary & holds)
        held = holds[first:]
        found, unread = with_beside(found, tries.take(held)), tries.take(~held)
        read = read.take(np.concatenate([np.arange(first), first + np.flatnonzero(held)]))
    return Sweep(found=found, read=read, nonce=identity, able=able, rounded=rounded, unread=unread)


def _all(
    points: FloatArray, parts: _Parts, chosen: NDArray[np.bool_], setting: Setting, subkey: bytes
) -> Iterator[Candidates]:
    """Yield all candidates of the rings of chosen (p,) points, some rings at a time."""
    for group, shape in parts:
        rows = np.flatnonzero(chosen[group.vertex])
        for block in blocks(len(rows), _BLOCK):
            some = rows[block]
            yield all_candidates(points, group.take(some), shape.take(some), setting, subkey)


def _surely_none(found: Candidates, read: Read, setting: Setting) -> bool:
    """Return whether so few of many marks hold that there are none; of marked surfaces many are read plainly."""
    many = not setting.layout.pieces_only and len(found.vertex) >= _MANY
    return many and not beyond_luck(found, read.holds, setting.layout)


def able_rings(shape: RingShapes, setting: Setting) -> NDArray[np.bool_]:
    """Return (r,): which rings could carry a mark, of whatever level they may have had."""
    able = eligible(shape, setting.unit, setting.layout.levels, _MARGIN)
    level = np.floor(level_of(shape, setting.unit))
    for doubt in (-setting.doubts, setting.doubts):
        unit = setting.unit * 2.0 ** (doubt / 2.0)
        rows = np.flatnonzero(able & (np.floor(level_of(shape, unit)) != level))
        able[rows] = eligible(shape.take(rows), unit, setting.layout.levels, _MARGIN)
    return able


def vouched(parts: _Parts, passed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): which points are marks that hold, `passed` (p,), or in the ring of one."""
    verified = passed.copy()
    for group, _ in parts:
        verified[group.around[passed[group.vertex]]] = True
    return verified


def _around(parts: _Parts, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): the chosen points and the middles of rings that hold one."""
    around = chosen.copy()
    for group, _ in parts:
        around[group.vertex] |= chosen[group.around].any(axis=1)
    return around


def _reported_id(found: Candidates, key: Key, setting: Setting) -> int | None:
    """Return the model's id as the marks report it, None where they report none.

    Each point has one vote, which the ways to read it share. Of the likely ids it is that with which most of the
    other marks hold.
    """
    tries = np.bincount(found.vertex)
    header = found.take(found.kind == HEADER)
    read = read_marks(header, key, setting.layout, None)
    header, symbol = header.take(read.holds), read.symbol[read.holds]
    likely = read_header(header.index, symbol, 1.0 / tries[header.vertex], setting.layout.symbol)
    rest = np.flatnonzero(found.kind != HEADER)
    some = found.take(rest[:: max(len(rest) // _SAMPLE, 1)])
    if not likely:
        return None
    few = some.take(np.arange(0, len(some.vertex), _SCREENED))
    held = marks_of_ids(few, key, setting.layout, np.array(likely, np.uint64))
    likely = [likely[each] for each in np.flatnonzero(held >= held.max() / 2 - _BY_LUCK)]
    if len(likely) == 1:
        return likely[0]
    marks = [read_marks(some, key, setting.layout, each).holds.sum() for each in likely]
    return likely[int(np.argmax(marks))]

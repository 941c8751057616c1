"""Search for the step and the layout of the marks, which a suspect does not tell: all are tried on a sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.authentication.checks.ring_reading import chance_of, window_of
from meshmark.authentication.checks.words_once import WordsOnce
from meshmark.authentication.marks.candidates import (
    HEADER,
    Candidates,
    as_laid_out,
    candidates,
    joined,
    level_of,
    placed,
    places_off,
)
from meshmark.authentication.marks.ring_shapes import RingShapes, in_style, ring_shapes
from meshmark.authentication.marks.ring_ways import Ways, ways
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.marks.words import PURPOSE, bind, symbols_at
from meshmark.authentication.parameters import (
    FAR_AWAY,
    FINE,
    LEVELS,
    SMALL,
    SMALL_RINGS,
    WEB,
    WEB_GRID,
    Layout,
    Style,
)
from meshmark.coding.keys import Key
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray

__all__ = ["Setting", "all_candidates", "any_hold", "likeliest_setting", "plain_candidates", "plain_ways"]

# Points that are tried with every step; more where only one mark in eleven can be read, without the model's id.
_SAMPLE, _SAMPLE_BLIND = 600, 2500
# A ring this near (in levels) to where the level changes, or may change, is tried on both sides.
_LEVEL_DOUBT = 0.05
# Steps that are tried first, of each style: for this error over the diagonal, and this number of levels up, from
# a little below the finest that models get to eight times that; and those for a grid on the longest side, which is
# 0.58 to 1 diagonals long. What they report is taken where its chance is below this, and the doubt about the step
# (levels) at most that.
_LIKELY: tuple[tuple[Style, float, range], ...] = (
    (FINE, FAR_AWAY, range(-6, 2)),
    (WEB, WEB_GRID, range(-2, 3)),
)
_CLEAR_LOG10, _CLEAR = -6.0, 0.25
# Number of the marks that hold under one step which may do so by luck.
_BY_LUCK = 3
_SAME, _NEXT = 1e-9, 0.25
# Rings that are read at a time.
_BLOCK = 1 << 16


@dataclass(frozen=True, kw_only=True)
class Setting:
    """How marks were made, estimated from a sample.

    unit: the smallest step over the spread, in scene units; doubt: how far off it may be, in levels.
    layout: of the words; style: of the marks; count: marks of the sample. log10_chance: bound on that of as many by
    luck.
    """

    unit: float
    doubt: float
    layout: Layout
    style: Style
    count: int
    log10_chance: float

    @property
    def error(self) -> float:
        """Return the error of a coordinate that the marks were made for, in scene units."""
        return self.unit / self.style.unit

    @property
    def doubts(self) -> float:
        """Return by how much (levels) a ring's level may be off altogether."""
        return self.doubt + _LEVEL_DOUBT


def likeliest_setting(
    points: FloatArray,
    rings: list[Rings],
    shapes: list[RingShapes] | None,
    key: Key,
    nonce: int | None,
    *,
    likely_only: bool = False,
) -> Setting | None:
    """Return the step and layout under which most marks of a sample hold.

    shapes: of the rings; without them those of the sample are made, which is all that an unmarked surface needs.
    Steps that suit the surface's size come first, others where these are not clearly right, unless `likely_only`.
    """
    total = sum(len(group.vertex) for group in rings)
    sample = _sample(points, rings, shapes, _SAMPLE_BLIND if nonce is None else _SAMPLE)
    middles = np.concatenate([points[group.vertex] for group, _ in sample]) if sample else points[:0]
    diagonal = float(np.linalg.norm(np.ptp(middles, axis=0))) if len(middles) else 0.0
    if not diagonal > 0.0:  # no ring, or a single one
        return None
    once = [WordsOnce(key.subkey(PURPOSE), len(group.vertex)) for group, _ in sample]
    for style, error, near in _LIKELY:
        finest = style.unit * error * diagonal
        styled = [(group, in_style(shape, style)) for group, shape in sample]
        likely = [np.floor(level_of(shape, finest))[:, None] + np.array(near) for _, shape in styled]
        only = HEADER if nonce is None else None
        best = _best(_tried(points, styled, likely, once, only), style, key, nonce)
        if (
            best is not None
            and best.log10_chance <= _CLEAR_LOG10
            and best.doubt <= _CLEAR
            and _inside(best, finest, near)
        ):
            return best
    if likely_only:
        return None
    every_level = [np.tile(np.array(LEVELS), (len(group.vertex), 1)) for group, _ in sample]
    found = []
    for styles in _alike(total):
        styled = [(group, in_style(shape, styles[0])) for group, shape in sample]
        only = HEADER if nonce is None and SMALL not in styles else None
        tried = _tried(points, styled, every_level, once, only)
        found += [best for style in styles if (best := _best(tried, style, key, nonce)) is not None]
    return min(found, key=lambda each: each.log10_chance, default=None)


def any_hold(points: FloatArray, rings: list[Rings], key: Key, nonce: int | None) -> tuple[bool, bool]:
    """Return whether more marks of a sample may hold than luck lets hold, under any step and layout.

    With the nonce that the marks report, and with `nonce`, where there is one. What depends on neither is done
    once. Where it says no, `likeliest_setting`, whose sample may be another, hardly ever says more.
    """
    total = sum(len(group.vertex) for group in rings)
    sample = _sample(points, rings, None, _SAMPLE_BLIND)
    once = [WordsOnce(key.subkey(PURPOSE), len(group.vertex)) for group, _ in sample]
    every_level = [np.tile(np.array(LEVELS), (len(group.vertex), 1)) for group, _ in sample]
    blind = known = False
    for styles in _alike(total) if sample else ():
        styled = [(group, in_style(shape, styles[0])) for group, shape in sample]
        small = SMALL in styles
        tried = _tried(points, styled, every_level, once, None if small else HEADER)
        blind |= _beyond_luck(tried, styles, key, None)
        if nonce is not None:
            if not small:  # a part of the sample is enough
                apart = max(min(total, _SAMPLE_BLIND) // _SAMPLE, 1)
                levels = [np.where(np.arange(len(each))[:, None] % apart, -1, each) for each in every_level]
                tried = _tried(points, styled, levels, once, None)
            known |= _beyond_luck(tried, styles, key, nonce)
    return blind, known


def _beyond_luck(tried: _Tried, styles: tuple[Style, ...], key: Key, nonce: int | None) -> bool:
    best = (_best(tried, style, key, nonce) for style in styles)
    return any(each is not None and each.log10_chance < 0.0 for each in best)


def _sample(
    points: FloatArray, rings: list[Rings], shapes: list[RingShapes] | None, about: int
) -> list[tuple[Rings, RingShapes]]:
    """Return about so many of the rings, or all, and their shapes."""
    every = max(sum(len(group.vertex) for group in rings) // about, 1)
    sample = []
    for number, group in enumerate(rings):
        rows = np.arange(0, len(group.vertex), every)
        some = group.take(rows)
        sample.append((some, ring_shapes(points, some) if shapes is None else shapes[number].take(rows)))
    return sample


def _alike(total: int) -> tuple[tuple[Style, ...], ...]:
    """Return the styles of marks of a surface of so many rings; those of each lie alike."""
    return (FINE,) if total > SMALL_RINGS else (FINE, SMALL), (WEB,)


def _inside(best: Setting, finest: float, near: range) -> bool:
    """Return whether all rings were tried with the levels of this setting: past the last ones marks are missed."""
    least = 2.0 * float(np.log2(best.unit / finest))
    return 1 - near.stop <= least - best.doubt and least + best.doubt <= -near.start


@dataclass(frozen=True, eq=False, kw_only=True)
class _Tried:
    """Candidates of rings that are each tried with several steps; size: (c,) of the smallest step, in levels."""

    found: Candidates
    size: FloatArray


def _tried(
    points: FloatArray,
    sample: list[tuple[Rings, RingShapes]],
    levels: list[FloatArray],
    once: list[WordsOnce],
    only: int | None,
) -> _Tried:
    """Return the candidates of rings with `levels` (r, k); `only` those of a kind."""
    parts = []
    for (group, shape), level, words in zip(sample, levels, once, strict=True):
        row, column = np.nonzero((level >= LEVELS[0]) & (level <= LEVELS[-1]))
        tried = level[row, column].astype(np.int64)
        shaped = shape.take(row)
        hashed = words.of(row, tried)
        found = candidates(points, group.take(row), shaped, tried, hashed, all_ways=False, only=only)
        parts.append(((level_of(shaped, 1.0) - tried)[found.ring], found))
    return _Tried(found=joined([part[1] for part in parts]), size=np.concatenate([part[0] for part in parts]))


def _best(tried: _Tried, style: Style, key: Key, nonce: int | None) -> Setting | None:
    """Return the likeliest setting of a style; without the model's id only marks that tell it can be read."""
    found, size = as_laid_out(tried.found, style.layouts[0]), tried.size
    if nonce is None:
        some = found.kind == HEADER
        found, size = found.take(some), size[some]
    bound = bind(found, key, nonce)
    order = np.argsort(size)
    off = places_off(found) / found.swing
    best = None
    for layout in style.layouts:
        _, holds = symbols_at(found.whole, found.boundary, bound, layout)
        held = order[holds[order]]
        inside = held[slice(*_densest(size[held])[:2])]
        held = held[off[held] <= window_of(off[inside], layout)]
        first, last, least, most = _densest(size[held])
        if last - first > (best.count if best is not None else 0):
            middle, doubt = (least + most) / 2.0, (most - least) / 2.0
            within = (size >= middle) & (size <= middle + 1.0)
            chance = chance_of(found.take(within), holds[within], layout, without_boundary=False)
            best = Setting(
                unit=2.0 ** (middle / 2.0),
                doubt=doubt,
                layout=layout,
                style=style,
                count=last - first,
                log10_chance=chance,
            )
    return best


def _densest(values: FloatArray) -> tuple[int, int, float, float]:
    """Return which of the sorted values, first and last + 1, lie in the interval of length 1 that holds most.

    And the least and the most where an interval may start that holds all but the few that may be there by luck.
    """
    if not len(values):
        return 0, 0, 0.0, 0.0
    counts = np.searchsorted(values, values + 1.0, side="right") - np.arange(len(values))
    best = int(counts.argmax())
    starts = np.concatenate([values, values - 1.0])
    lowest = values[best + counts[best] - 1] - 1.0  # from here to the first one the same are held
    starts = starts[(starts >= lowest - _NEXT) & (starts <= values[best] + _NEXT)]
    held = np.searchsorted(values, starts + 1.0 + _SAME, side="right")
    held -= np.searchsorted(values, starts - _SAME)
    good = starts[held >= counts[best] - _BY_LUCK]
    return best, best + int(counts[best]), float(good.min()), float(good.max())


def plain_ways(rings: Rings, shapes: RingShapes, setting: Setting, subkey: bytes) -> list[Ways]:
    """Return the one way to read each ring that a file of full precision has, block by block."""
    level = np.floor(level_of(shapes, setting.unit)).astype(np.int64)
    possible = np.flatnonzero((level >= LEVELS[0]) & (level <= LEVELS[-1]))
    rows = [possible[block] for block in blocks(max(len(possible), 1), _BLOCK)]
    return [ways(rings, shapes, some, level[some], subkey, all_ways=False) for some in rows]


def plain_candidates(
    points: FloatArray, rings: Rings, shapes: RingShapes, setting: Setting, subkey: bytes
) -> Candidates:
    """Return the one candidate of each ring that a file of full precision has."""
    plain = plain_ways(rings, shapes, setting, subkey)
    return as_laid_out(joined(placed(points, found) for found in plain), setting.layout)


def all_candidates(
    points: FloatArray, rings: Rings, shapes: RingShapes, setting: Setting, subkey: bytes
) -> Candidates:
    """Return every candidate of rings for marks of this setting, on both levels near where it changes."""
    exact = level_of(shapes, setting.unit)
    doubt = setting.doubts
    level = np.floor(exact).astype(np.int64)
    parts = []
    for change, doubtful in (
        (0, np.ones(len(exact), bool)),
        (-1, exact - level < doubt),
        (1, exact - level > 1.0 - doubt),
    ):
        rows = np.flatnonzero(doubtful & (level + change >= LEVELS[0]) & (level + change <= LEVELS[-1]))
        parts.append(
            candidates(
                points, rings.take(rows), shapes.take(rows), level[rows] + change, subkey, all_ways=True
            )
        )
    return as_laid_out(joined(parts), setting.layout)

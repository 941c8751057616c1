"""Search for the step and the layout of the marks, which a suspect does not tell: all are tried on a sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.carriers.rings import Rings
from meshmark.carriers.rings_shape import RingShapes
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray
from meshmark.schemes.ncdg_lv.authentication.candidates import (
    HEADER,
    Candidates,
    candidates,
    joined,
    level_of,
)
from meshmark.schemes.ncdg_lv.authentication.parameters import LAYOUTS, LEVELS, Layout
from meshmark.schemes.ncdg_lv.authentication.words import PURPOSE, bind, symbols_at

__all__ = ["Setting", "all_candidates", "likeliest_setting"]

# Points that are tried with every step; more where only one mark in eleven can be read, without the model's id.
_SAMPLE, _SAMPLE_BLIND = 600, 2500
# A ring this near (in levels) to where the level changes, or may change, is tried on both sides.
_LEVEL_DOUBT = 0.05


@dataclass(frozen=True)
class Setting:
    """How marks were made, as a sample tells.

    unit: the smallest step over the spread, in scene units; doubt: how far off it may be, in levels.
    layout: of the words; count: marks of the sample.
    """

    unit: float
    doubt: float
    layout: Layout
    count: int


def likeliest_setting(
    points: FloatArray, rings: list[Rings], shapes: list[RingShapes], key: Key, nonce: int | None
) -> Setting | None:
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
    best: Setting | None = None
    for layout in LAYOUTS.values():
        _, holds = symbols_at(places, found.rim, bound, layout)
        start, doubt, count = _densest(np.sort(size[holds]))
        if best is None or count > best.count:
            best = Setting(2.0 ** (start / 2.0), doubt, layout, count)
    return best if best is not None and best.count else None


def _densest(values: FloatArray) -> tuple[float, float, int]:
    """Return start, its uncertainty, and count of the interval of length 1 that holds most of the sorted values.

    The interval may start anywhere between its last value less 1 and its first.
    """
    if not len(values):
        return 0.0, 0.0, 0
    counts = np.searchsorted(values, values + 1.0) - np.arange(len(values))
    best = int(counts.argmax())
    latest, earliest = values[best], values[best + counts[best] - 1] - 1.0
    return float(latest + earliest) / 2.0, float(latest - earliest) / 2.0, int(counts[best])


def all_candidates(
    points: FloatArray, rings: Rings, shapes: RingShapes, setting: Setting, subkey: bytes
) -> Candidates:
    """Return every candidate of rings for marks of this setting, on both levels near where it changes."""
    exact = level_of(shapes, setting.unit)
    doubt = setting.doubt + _LEVEL_DOUBT
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
    return joined(parts)

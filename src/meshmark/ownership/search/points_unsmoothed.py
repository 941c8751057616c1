"""Readings of the points of a coarse suspect that was smoothed, with what common tools do taken back exactly.

A step of a mark at points is far smaller than what smoothing moves them by, so that nothing is left of it; but the
inverse brings every point back to its place, up to rounding.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from meshmark.geometry.frame import frame_alternatives
from meshmark.geometry.surface import Surface
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import STEPS, SURELY_SKEW
from meshmark.ownership.points.point_choice import cuts_of
from meshmark.ownership.points.point_reading import CHOICES, Framed
from meshmark.ownership.quick_waves import quick_cosine
from meshmark.ownership.search.at_points import readings_of_points
from meshmark.ownership.search.inverse_smoothing import SHAPES
from meshmark.ownership.search.search import Search

__all__ = ["readings_of_points_unsmoothed"]

# Coordinates by which a shape is judged in each turn, of the likeliest label; and what the chance of its best lock
# must be below, over all that are tried, for it to be read.
JUDGES, BELIEVED = 4000, 1e-3


def readings_of_points_unsmoothed(search: Search) -> Iterator[Reading]:
    """Yield the readings of those surfaces that the suspect may have been before whose points lock."""
    for before in search.before_smoothing:
        if _may_lock(search, before):
            there = replace(search, surface=before)
            for reading in readings_of_points(there, swept=False):
                yield replace(reading, hypotheses=reading.hypotheses * SHAPES)


def _may_lock(search: Search, surface: Surface) -> bool:
    """Return whether the points of a surface say more under the likeliest label than by chance."""
    label = search.labels(surface.invariants, at_points=True)[0]
    lattice = search.point_lattice(label)
    turns = list(frame_alternatives(surface.frame, True, SURELY_SKEW))
    carried = Carried.of(surface, surface.frame)
    limit = np.log10(BELIEVED / (SHAPES * CHOICES * len(turns)))
    framed = (Framed.of(surface, carried, turned, lattice) for turned in turns)
    return any(_least_chance(each) < limit for each in framed)


def _least_chance(framed: Framed) -> float:
    """Return about log10 of the chance of the choice that locks best.

    What coordinates in one cube have in common is left out: a reading counts it.
    """
    few = framed.first(framed.coordinates[-1], JUDGES)
    order = np.argsort(framed.keys.draw[few], kind="stable")
    draw, place, dither = (each[few][order] for each in (framed.keys.draw, framed.points, framed.keys.dither))
    room = framed.room[:, np.nonzero(few)[0][order]]
    cosine = quick_cosine(2.0 * (place / STEPS[:, None] - dither))
    most = 0.0
    for mode, coordinates in enumerate(framed.coordinates):
        carries = room & coordinates[few][order]
        ends = np.searchsorted(draw, cuts_of(mode)) - 1
        ends = ends[ends >= 0]
        count = np.cumsum(carries, axis=1)[:, ends]
        score = np.cumsum(np.where(carries, cosine, 0.0), axis=1, dtype=np.float64)[:, ends]
        locks = np.where((count >= framed.readable) & (score > 0.0), score**2 / np.maximum(count, 1), 0.0)
        most = max(most, float(locks.max(initial=0.0)))
    return -most / float(np.log(10.0))

"""Which points of a model that was just marked have no mark left that is read once its positions are rounded.

Who made the marks knows where they are and what each should say. So their rings alone are read, about a fifth of
all, without a search for how they were made and without MACs: this takes a fraction of what an examination takes.
It finds what an examination would call altered but for few points, and proves nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray
from meshmark.authentication.checks.ring_reading import window_of
from meshmark.authentication.checks.setting_search import Setting, all_candidates, plain_candidates
from meshmark.authentication.checks.sweep import NEAR, ROUNDED, able_rings, vouched
from meshmark.authentication.marks.candidates import Candidates, joined
from meshmark.authentication.marks.plan import Marked, Plan
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.words import PURPOSE
from meshmark.authentication.parameters import UNREADABLE, Style
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray

__all__ = ["unread_when_rounded"]


def unread_when_rounded(
    plan: Plan, marked: Marked, rounded: FloatArray, key: Key, style: Style
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return next to which points no mark is read, though one could be, and which marks fail.

    Parameters
    ----------
    plan : Plan
        Of p points.
    marked : Marked
        The marks of this plan.
    rounded : (p, 3) float array
        The marked points after a similarity transform, or none, and rounding.
    key : Key
    style : Style
        Of the marks.

    Returns
    -------
    unread : (p,) bool array
    failing : (p,) bool array
        Points whose marks are not read.
    """
    count = len(rounded)
    rings = rings_of(plan.surface)
    unit = plan.unit * _size(rounded) / _size(marked.points)  # a similarity transform may have come before
    setting = Setting(
        unit=unit, doubt=0.0, layout=plan.layout, style=style, count=marked.count, log10_chance=0.0
    )
    row_of = np.full(count, -1)
    row_of[plan.marks] = np.arange(len(plan.marks))
    of_marks = [group.take(row_of[group.vertex] >= 0) for group in rings]
    parts = [(group, ring_shapes(rounded, group, style)) for group in of_marks]
    subkey = key.subkey(PURPOSE)
    held = np.zeros(count, bool)

    def read(found: Candidates) -> tuple[AnyIntArray, FloatArray, FloatArray]:
        """Return the points of candidates in rings as they were made, how far off their places they lie in steps,
        and over what makes them swing.
        """
        same = found.name == plan.found.name[row_of[found.vertex]]
        found = found.take(same & (found.swing < UNREADABLE))
        steps = np.abs(found.place - marked.place[row_of[found.vertex]]).max(axis=1)
        return found.vertex, steps, steps / found.swing

    vertex, steps, off = read(joined([plain_candidates(rounded, *part, setting, subkey) for part in parts]))
    # As a sweep does, which tries the next whole places, too, where the file was rounded to few digits.
    near = off[steps < 0.5]
    coarse = len(near) > 0 and float(np.median(near)) > ROUNDED
    farthest, window = 1.0 - NEAR if coarse else 0.5, window_of(near, plan.layout)
    held[vertex[(steps <= farthest) & (off <= window)]] = True
    missed = [np.flatnonzero(~held[group.vertex]) for group, _ in parts]
    if any(len(rows) for rows in missed):
        rest = [
            all_candidates(rounded, group.take(rows), shape.take(rows), setting, subkey)
            for (group, shape), rows in zip(parts, missed, strict=True)
        ]
        vertex, steps, off = read(joined(rest))
        held[vertex[(steps <= farthest) & (off <= window)]] = True
    unread = np.zeros(count, bool)
    left = ~vouched(parts, held)
    for group in rings:
        rows = np.flatnonzero(left[group.vertex])
        if len(rows):
            some = group.take(rows)
            unread[some.vertex] = able_rings(ring_shapes(rounded, some, style), setting)
    return unread, (row_of >= 0) & ~held


def _size(points: FloatArray) -> float:
    return float(np.sqrt(np.square(points - points.mean(axis=0)).sum()))

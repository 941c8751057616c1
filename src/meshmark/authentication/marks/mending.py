"""Other marks near points that a rounding leaves without one that is read: the rest of a plan stays as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import joined
from meshmark.authentication.marks.choice import completed
from meshmark.authentication.marks.plan import Plan
from meshmark.authentication.marks.ring_room import RingRoom, covered
from meshmark.authentication.parameters import Style
from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface

__all__ = ["mended"]

# Where no ring next to a point has room for a mark, one of which too many lengths are in doubt may bear what is
# promised: it is enough if they are not in doubt for this share of the tolerance.
_DOUBT = 0.5


def mended(plan: Plan, key: Key, unread: NDArray[np.bool_], avoid: NDArray[np.bool_], style: Style) -> Plan:
    """Return a plan whose marks near some points are chosen anew.

    Neighbours of these points come first: some had no room for a mark, so that none was next to them, but have it
    in the rounded file. The present marks next to them, which were not read, come last, as others do that are to be
    avoided. A point without another neighbour for a mark gets one in a ring that other roundings than those that
    were promised may change. The points that carry marks stay a maximal set without neighbours.

    Parameters
    ----------
    plan : Plan
        Of p points.
    key : Key
    unread : (p,) bool array
        The points near which no mark is read.
    avoid : (p,) bool array
        Points whose marks are known not to be read.
    style : Style
        Of the marks.

    Returns
    -------
    Plan
    """
    surface, connectivity = plan.surface, plan.surface.connectivity
    before = np.zeros(len(surface.points), bool)
    before[plan.marks] = True
    near = _with_ring(surface, unread)
    opened = _with_ring(surface, _with_ring(surface, near))
    kept = before & ~opened
    rings = RingRoom.of(surface, plan.unit, style, _with_ring(surface, opened))
    allowed = rings.allowed(plan.layout.levels)
    chance = unit_interval(keyed_words(key.subkey("authentication marks mended"), len(before)))
    nearest = allowed & near & ~before & ~avoid
    chosen = completed(connectivity, kept, nearest, nearest, chance)
    chosen = completed(connectivity, chosen, allowed, rings.firm & ~(near & before) & ~avoid, chance)
    left = unread & ~_with_ring(surface, chosen)
    if left.any():
        last = _with_ring(surface, left) & rings.doubtful(plan.layout.levels, _DOUBT)
        chosen = completed(connectivity, chosen, last, last & ~avoid, chance)
    added = rings.found(chosen & ~before, key, plan.layout)
    found = joined([plan.found.take(chosen[plan.found.vertex]), added])
    return replace(plan, found=found, covered=covered(surface, chosen))


def _with_ring(surface: Surface, some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): some points and their neighbours."""
    return np.asarray(some | (surface.graph @ some.astype(np.float64) > 0.0))

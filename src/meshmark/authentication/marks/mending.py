"""Other marks near points that a rounding leaves without one that is read: the rest of a plan stays as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import joined
from meshmark.authentication.marks.choice import completed
from meshmark.authentication.marks.plan import Plan
from meshmark.authentication.marks.ring_room import RingRoom
from meshmark.authentication.parameters import Style
from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface

__all__ = ["mended"]


def mended(plan: Plan, key: Key, unread: NDArray[np.bool_], style: Style) -> Plan:
    """Return a plan whose marks near the points `unread` (p,) are chosen anew.

    Neighbours of these points come first: some had no room for a mark, so that none was next to them, but have it
    in the rounded file. The present marks next to them, which were not read, come last. style: of the marks. The
    points that carry marks stay a maximal set without neighbours.
    """
    surface, connectivity = plan.surface, plan.surface.connectivity
    rings = RingRoom.of(surface, plan.unit, style)
    before = np.zeros(len(surface.points), bool)
    before[plan.marks] = True
    near = _with_ring(surface, unread)
    kept = before & ~_with_ring(surface, _with_ring(surface, near))
    allowed = rings.allowed(plan.layout.levels)
    chance = unit_interval(keyed_words(key.subkey("authentication marks mended"), len(before)))
    nearest = allowed & near & ~before
    chosen = completed(connectivity, kept, nearest, nearest, chance)
    chosen = completed(connectivity, chosen, allowed, rings.firm & ~(near & before), chance)
    added = rings.found(chosen & ~before, key, plan.layout)
    found = joined([plan.found.take(chosen[plan.found.vertex]), added])
    return replace(plan, found=found, covered=rings.covered(chosen))


def _with_ring(surface: Surface, some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): some points and their neighbours."""
    return np.asarray(some | (surface.graph @ some.astype(np.float64) > 0.0))

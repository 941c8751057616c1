"""Other marks near points that a rounding leaves without one that is read: the rest of a plan stays as it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import joined
from meshmark.authentication.marks.choice import SCARCE, completed
from meshmark.authentication.marks.plan import Plan
from meshmark.authentication.marks.ring_room import RingRoom, covered
from meshmark.authentication.parameters import Style
from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface

__all__ = ["Doubts", "few_enough", "mended"]

# Where no ring next to a point has room for a mark, one of which too many lengths are in doubt may bear what is
# promised: it is enough if they are not in doubt for this share of the tolerance.
_DOUBT = 0.5
# The share of the points, or the number, near which marks are chosen anew; where more fail, all are.
_FEW, _LEAST = 1e-3, 2
# Keyed choices that are tried until none of the points that were unread before is left alone.
_CHOICES = 8


def few_enough(unread: NDArray[np.bool_]) -> bool:
    """Return whether so few points, `unread` (p,), have no mark that is read that a plan is mended near them."""
    return bool(unread.sum() <= max(_FEW * len(unread), _LEAST))


@dataclass(frozen=True, eq=False, kw_only=True)
class Doubts:
    """What is known of p points of a plan.

    unread: near which no mark is read. ever: near which none was read of this plan or an earlier one. failing:
    whose marks are known not to be read.
    """

    unread: NDArray[np.bool_]
    ever: NDArray[np.bool_]
    failing: NDArray[np.bool_]


def mended(plan: Plan, key: Key, doubts: Doubts, style: Style) -> Plan:
    """Return a plan whose marks near some points are chosen anew.

    The marks next to the points that are unread, and others that are known to fail, come last. A point without
    another neighbour for a mark gets one in a ring that other roundings than those that were promised may change.
    Points with the fewest such neighbours come first, and count among them those that were unread before: or two
    choices would take turns. The points that carry marks stay a maximal set without neighbours.

    Parameters
    ----------
    plan : Plan
        Of p points.
    key : Key
    doubts : Doubts
    style : Style
        Of the marks.

    Returns
    -------
    Plan
    """
    surface = plan.surface
    before = np.zeros(len(surface.points), bool)
    before[plan.marks] = True
    near = _with_ring(surface, doubts.unread)
    opened = _with_ring(surface, _with_ring(surface, near))
    rings = RingRoom.of(surface, plan.unit, style, _with_ring(surface, opened))
    levels, tried = plan.layout.levels, doubts.failing | (near & before)
    allowed = rings.allowed(levels)
    wanted = doubts.ever & _with_ring(surface, opened)
    able = (allowed | rings.doubtful(levels, _DOUBT)) & ~tried & _with_ring(surface, wanted)
    options = surface.connectivity.graph @ able.astype(np.float64) + able
    best, fewest = before, len(before) + 1
    for choice in range(_CHOICES):
        chance = unit_interval(keyed_words(key.subkey(f"authentication marks mended {choice}"), len(before)))
        chosen = before & ~opened
        for most in (*SCARCE, np.inf):
            alone = wanted & (options <= most) & ~_with_ring(surface, chosen & ~tried)
            some = able & _with_ring(surface, alone)
            chosen = completed(surface.connectivity, chosen, some, (allowed,), chance)
        chosen = completed(surface.connectivity, chosen, allowed, (rings.firm & ~tried,), chance)
        left = int((wanted & ~_with_ring(surface, chosen & ~tried)).sum())
        if left < fewest:
            best, fewest = chosen, left
        if not fewest:
            break
    added = rings.found(best & ~before, key, plan.layout)
    found = joined([plan.found.take(best[plan.found.vertex]), added])
    return replace(plan, found=found, covered=covered(surface, best))


def _with_ring(surface: Surface, some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): some points and their neighbours."""
    return np.asarray(some | (surface.graph @ some.astype(np.float64) > 0.0))

"""Which points carry marks: an independent set, of points whose marks are firm and whose rings are unlike first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import HEADER, Candidates
from meshmark.authentication.marks.independent_points import independent_points
from meshmark.geometry.connectivity import Connectivity
from meshmark.mesh import FloatArray, IntArray

__all__ = ["SCARCE", "alike", "completed"]

SCARCE = (1, 2)
"""Points with so few neighbours that may carry marks which are read come first."""
# How often they are chosen anew.
_TIMES = 4


def completed(
    connectivity: Connectivity,
    chosen: NDArray[np.bool_],
    allowed: NDArray[np.bool_],
    first: Sequence[NDArray[np.bool_]],
    chance: FloatArray,
) -> NDArray[np.bool_]:
    """Return (p,): the `chosen` points, which are no neighbours, and more until the set is maximal.

    first: of the `allowed` (p,) points, those that come before the others, in one or more lists (p,), best first.
    The very first are those next to one of the others, which then needs no mark itself.
    """
    chosen = _beside(connectivity, chosen, allowed & first[0], allowed & ~first[-1], chance)
    for some in (*first, allowed):
        chosen = _more(connectivity, chosen, allowed & some, chance)
    return chosen


def _beside(
    connectivity: Connectivity,
    chosen: NDArray[np.bool_],
    able: NDArray[np.bool_],
    others: NDArray[np.bool_],
    chance: FloatArray,
) -> NDArray[np.bool_]:
    """Return the chosen points and some that are able, so that most others, all (p,), have one as a neighbour.

    Of those that are able the ones with the fewest able neighbours, which they would rule out, come first. Others
    that were left without one have their turn first the next time.
    """
    options = connectivity.graph @ able.astype(np.float64)
    others = others & (options > 0.0) & ~chosen
    urgent, best, fewest = np.zeros_like(others), chosen, int(others.sum())
    for _ in range(_TIMES):
        if not fewest:
            break
        tried = chosen
        for some in (urgent, *(others & (options <= most) for most in SCARCE), others):
            beside = able & _near(connectivity, some & ~_near(connectivity, tried))
            ruled_out = connectivity.graph @ beside.astype(np.float64)
            tried = _more(connectivity, tried, beside, ruled_out + chance)
        left = others & ~_near(connectivity, tried)
        if left.sum() < fewest:
            best, fewest = tried, int(left.sum())
        urgent |= left
    return best


def _more(
    connectivity: Connectivity, chosen: NDArray[np.bool_], allowed: NDArray[np.bool_], chance: FloatArray
) -> NDArray[np.bool_]:
    """Return the chosen points and a maximal set of the allowed ones that leaves no two neighbours, all (p,)."""
    free = allowed & ~chosen
    if free.any():
        free[free] = ~_near(connectivity, chosen)[free]
    return chosen | independent_points(connectivity.edges, free, chance) if free.any() else chosen


def _near(connectivity: Connectivity, some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.asarray(connectivity.graph @ some.astype(np.float64) > 0.0)


def alike(found: Candidates, kept: NDArray[np.bool_] | None = None) -> IntArray:
    """Return the points of marks that tell the id whose rings are those of another one, but for one of each.

    kept: (p,) points of which that one is, if it can be.
    """
    header = found.take(found.kind == HEADER)
    if kept is not None:
        header = header.take(np.argsort(~kept[header.vertex], kind="stable"))
    first = np.unique(header.name, return_index=True)[1]
    return np.delete(header.vertex, first)

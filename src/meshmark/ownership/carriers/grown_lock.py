"""Locking a few cells first and growing from there (docs/design.md, section 4, lattice lock).

Cells whose phases are single, the pilots, are locked with far fewer corrections than all at once, as the phases of
the others are doubled. Where there are more pilots than needed, those of one side of the model are taken, which
hardly feel a turn or a growth about their own centre. The best corrections are then held to more and more cells,
each time with little left to search.
"""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lock import Lock, LockSearch
from meshmark.ownership.carriers.lock_grid import grid_size

__all__ = ["MOST_FIRST", "grown", "neighbourhood"]

# Cells that are locked first, of those of most weight (mostly all pilots), and by how much the next are more. Cells
# of a mark that is not to be seen say little each: by 45 two thirds as many locks stand out (decision 0048).
FIRST, GROWTH = 80, 2.2
# Corrections tried at most in the first cluster and in the others.
MOST_FIRST, MOST_NEXT = 400_000, 4_000
# Number of corrections of the first cluster that are followed, and the standard deviations by which they stand out.
KEPT, STANDS_OUT = 5, 5.5
# On the grid the score is at least about this share of what it is at the top next to it.
ON_GRID = 0.65
# Number of places of which one is the middle of the first cluster.
PLACES = 40
RADIUS, NEXT_RADIUS = 2.5, 3.0


def neighbourhood(response: FloatArray, places: FloatArray, weight: FloatArray) -> IntArray:
    """Return the order of the cells (n,) by the distance from where a first cluster takes fewest corrections.

    response: (n, d) change of the phases per standard deviation of each part; places: (n, 3) of the cells; weight:
    (n,) as in `LockSearch`.
    """
    if len(places) <= FIRST:
        return np.arange(len(places))
    centres = places[:: -(-len(places) // PLACES)]
    if np.count_nonzero(weight == weight.max()) <= FIRST:  # all of them, wherever the middle is
        centres = centres[:1]
    orders = (np.argsort(((places - centre) ** 2).sum(axis=1), kind="stable") for centre in centres)
    return min(orders, key=lambda order: grid_size(response[_first(order, weight)], RADIUS))


def _first(order: IntArray, weight: FloatArray) -> IntArray:
    """Return the cells of the first cluster of an order."""
    heaviest: IntArray = order[weight[order] == weight.max()]
    return heaviest[:FIRST]


def grown(
    psi: FloatArray,
    gradient: FloatArray,
    expected: FloatArray,
    order: IntArray,
    most: int = MOST_FIRST,
    *,
    weight: FloatArray,
) -> Lock | None:
    """Return the best correction found, or None where the first cluster does not lock.

    psi, gradient, expected: as in `LockSearch`; order: (n,) of the cells, those of the first cluster first (see
    `neighbourhood`); most: corrections tried in the first cluster.
    `tried` of the result counts the corrections that all cells together could distinguish within the radius; its
    score is that of the best of them.
    """
    response = gradient * expected
    cluster = _first(order, weight)
    search = LockSearch(psi[cluster], gradient[cluster], expected, RADIUS, most, weight=weight[cluster])
    least = STANDS_OUT * np.sqrt(weight[cluster] @ weight[cluster] / 2.0)
    rough = [lock for lock in search.rough(KEPT) if lock.score > ON_GRID * least]
    locks = [lock for lock in search.polished(rough) if lock.score > least]
    if not locks:
        return None
    best = max(
        (_grow(psi, gradient, expected, lock.correction, order=order, weight=weight) for lock in locks),
        key=lambda lock: lock.score,
    )
    return Lock(correction=best.correction, score=best.score, tried=grid_size(response, RADIUS))


def _grow(
    psi: FloatArray,
    gradient: FloatArray,
    expected: FloatArray,
    place: FloatArray,
    *,
    order: IntArray,
    weight: FloatArray,
) -> Lock:
    """Return the lock of all cells that a lock of the first few, at `place` (d,), leads to."""
    count = int(np.flatnonzero(np.isin(order, _first(order, weight)))[-1]) + 1
    while True:
        held = order[:count]
        # What the cells so far leave open: the inverse of their information, with what was expected at first.
        information = weight[held] * np.maximum(np.cos(psi[held] + gradient[held] @ place), 0.0)
        response = gradient[held] * expected
        values, turn = np.linalg.eigh((response.T * information) @ response + np.eye(len(expected)))
        ways = expected[:, None] * (turn / np.sqrt(values))
        count = min(int(count * GROWTH), len(order))
        wider = order[:count]
        search = LockSearch(
            psi[wider] + gradient[wider] @ place,
            gradient[wider] @ ways,
            np.ones(len(values)),
            NEXT_RADIUS,
            MOST_NEXT,
            weight=weight[wider],
        )
        (lock,) = search.polished(search.rough(1))
        place = place + ways @ lock.correction
        if count == len(order):
            return Lock(correction=place, score=lock.score, tried=lock.tried)

"""Locking a few neighbouring cells first and growing from there (docs/design.md, section 4, lattice lock).

A cluster of cells on one side of the model hardly feels a turn or a growth about its own centre: it is locked with
thousands of times fewer corrections than all cells at once. The best are then held to wider and wider clusters,
each of which leaves little to search in the next.
"""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lock import Lock, LockSearch
from meshmark.ownership.carriers.lock_grid import grid_size

__all__ = ["MOST_FIRST", "grown", "neighbourhoods"]

# Cells in the first cluster, those of most weight (pilots: single phases take few corrections even far apart), and
# by how much the next is larger. Cells of a mark that is not to be seen say little each: of 45 two thirds as many
# locks stand out as of 80, and of 120 no more (decision 0048).
FIRST, GROWTH = 80, 2.2
# Corrections tried at most in the first cluster and in the others.
MOST_FIRST, MOST_NEXT = 400_000, 4_000
# Number of corrections of the first cluster that are followed, and the standard deviations by which they stand out.
KEPT, STANDS_OUT = 5, 5.5
# On the grid the score is at least about this share of what it is at the top next to it.
ON_GRID = 0.65
# Number of places around which clusters are tried.
PLACES = 40
RADIUS, NEXT_RADIUS = 2.5, 3.0


def neighbourhoods(
    response: FloatArray, places: FloatArray, weight: FloatArray, count: int
) -> list[IntArray]:
    """Return orders of the cells (n,), each by the distance from where a cluster takes few corrections.

    The first takes fewest; of the next ones no first cluster shares a cell with those before.
    response: (n, d) change of the phases per standard deviation of each part; places: (n, 3) of the cells; weight:
    (n,) as in `LockSearch`.
    """
    if len(places) <= FIRST:
        return [np.arange(len(places))]
    centres = places[:: -(-len(places) // PLACES)]
    orders = [np.argsort(((places - centre) ** 2).sum(axis=1), kind="stable") for centre in centres]
    orders.sort(key=lambda order: grid_size(response[_first(order, weight)], RADIUS))
    chosen: list[IntArray] = []
    taken = np.zeros(len(places), dtype=bool)
    for order in orders:
        if len(chosen) < count and not taken[_first(order, weight)].any():
            chosen.append(order)
            taken[_first(order, weight)] = True
    return chosen


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
    `neighbourhoods`); most: corrections tried in the first cluster.
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

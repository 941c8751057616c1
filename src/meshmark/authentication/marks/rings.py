"""The ring of neighbours of each point, in the order in which the faces turn about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import IntArray

__all__ = ["LARGEST", "SMALLEST", "Rings", "ordered_rings"]

# A ring of fewer neighbours has no plane of its own; one of more is a hub, whose faces are slivers.
SMALLEST, LARGEST = 3, 14


@dataclass(frozen=True, eq=False, kw_only=True)
class Rings:
    """Points whose rings have k neighbours each.

    vertex: (r,) point indices. around: (r, k) the neighbours, counter-clockwise seen from outside; of a point on a
    boundary from the first to the last, of any other from any of them. open: (r,) whether it is on a boundary.
    boundary: (r, k) whether each neighbour is on a boundary, or where surfaces meet in no single fan.
    """

    vertex: IntArray
    around: IntArray
    open: NDArray[np.bool_]
    boundary: NDArray[np.bool_]

    def take(self, rows: IntArray | NDArray[np.bool_] | slice) -> Rings:
        """Return these rows."""
        return Rings(
            vertex=self.vertex[rows],
            around=self.around[rows],
            open=self.open[rows],
            boundary=self.boundary[rows],
        )


def ordered_rings(faces: IntArray, count: int) -> list[Rings]:
    """Return the rings of the points whose faces (m, 3) make one fan, by their size, 3 to 14 neighbours.

    Points where faces turn against each other, or where several fans meet, have none.
    """
    centre = faces.ravel()
    start = faces[:, [1, 2, 0]].ravel()
    end = faces[:, [2, 0, 1]].ravel()
    following, doubtful = _following(centre, start, end, count)
    has_previous = np.zeros(len(centre), bool)
    has_previous[following[following >= 0]] = True
    corners = np.bincount(centre, minlength=count)
    ends = np.bincount(centre[following < 0], minlength=count)
    good = ~doubtful & (ends <= 1)
    # Walk from the corner that nobody precedes, where there is one; else from any.
    first = np.full(count, -1)
    first[centre] = np.arange(len(centre))
    first[centre[~has_previous]] = np.flatnonzero(~has_previous)
    boundary = ~(good & (ends == 0))
    rings = []
    for size in range(SMALLEST, LARGEST + 1):
        vertex = np.flatnonzero(good & (corners + ends == size))
        if len(vertex):
            around, whole = _walk(first[vertex], following, start, end, ends[vertex] == 1, size=size)
            vertex, around = vertex[whole], around[whole]
            rings.append(
                Rings(vertex=vertex, around=around, open=ends[vertex] == 1, boundary=boundary[around])
            )
    return [group for group in rings if len(group.vertex)]


def _following(
    centre: IntArray, start: IntArray, end: IntArray, count: int
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return for each corner the next about its point, -1 for none; and which points have two for one."""
    keys = (centre << 32) | start
    order = np.argsort(keys)
    keys = keys[order]
    wanted = (centre << 32) | end
    place = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    following = np.where(keys[place] == wanted, order[place], -1) if len(keys) else place
    doubtful = np.zeros(count, bool)
    doubtful[keys[1:][keys[1:] == keys[:-1]] >> 32] = True
    wanted.sort()
    doubtful[wanted[1:][wanted[1:] == wanted[:-1]] >> 32] = True
    return following, doubtful


def _walk(
    first: IntArray,
    following: IntArray,
    start: IntArray,
    end: IntArray,
    is_open: NDArray[np.bool_],
    *,
    size: int,
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the rings (r, size) that begin at corners `first` (r,), and which of them have no other fan."""
    around = np.empty((len(first), size), np.int64)
    corner = last = first
    whole = np.ones(len(first), bool)
    for step in range(size):
        around[:, step] = start[corner]
        if step == size - 1:
            around[is_open, step] = end[last[is_open]]
            break
        last, corner = corner, np.where(following[corner] < 0, corner, following[corner])
        # Back, or at the end, too soon: another fan is left over.
        whole &= np.where(is_open, (corner != last) | (step == size - 2), corner != first)
    return around, whole

"""The ring of neighbours of each point, in the order in which the faces turn about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import rows_of
from meshmark.geometry.blocks import blocks
from meshmark.geometry.corners import corners_of_points
from meshmark.mesh import IntArray

__all__ = ["LARGEST", "SMALLEST", "Rings", "ordered_rings"]

# A ring of fewer neighbours has no plane of its own; one of more is a hub, whose faces are slivers.
SMALLEST, LARGEST = 3, 14
# Points whose rings are walked at once: the corners of all of a large model would take gigabytes meanwhile.
_BLOCK = 1 << 16
# Which corner of a face follows each, and which comes before it.
_AFTER, _BEFORE = np.array([1, 2, 0]), np.array([2, 0, 1])


@dataclass(frozen=True, eq=False, kw_only=True)
class Rings:
    """Points whose rings have k neighbours each.

    vertex: (r,) point indices. around: (r, k) the neighbours, counter-clockwise seen from outside; of a point on a
    boundary from the first to the last, of any other from any of them. open: (r,) whether it is on a boundary.
    boundary: (r, k) whether each neighbour is on a boundary, or where surfaces meet in no single fan.
    """

    vertex: IntArray
    around: NDArray[np.int32]
    open: NDArray[np.bool_]
    boundary: NDArray[np.bool_]

    def take(self, rows: IntArray | NDArray[np.bool_] | slice) -> Rings:
        """Return these rows."""
        return Rings(
            vertex=rows_of(self.vertex, rows),
            around=rows_of(self.around, rows),
            open=rows_of(self.open, rows),
            boundary=rows_of(self.boundary, rows),
        )


def ordered_rings(faces: IntArray, count: int) -> list[Rings]:
    """Return the rings of the points whose faces (m, 3) make one fan, by their size, 3 to 14 neighbours.

    Points where faces turn against each other, or where several fans meet, have none.
    """
    boundary = np.ones(count, bool)
    found: dict[int, list[Rings]] = {size: [] for size in range(SMALLEST, LARGEST + 1)}
    at, face_of, slot_of = corners_of_points(faces, count)
    for block in blocks(count, _BLOCK):
        corners = slice(at[block.start], at[block.stop])
        centre = np.repeat(np.arange(block.stop - block.start), np.diff(at[block.start : block.stop + 1]))
        face, slot = faces[face_of[corners]], slot_of[corners]
        rows = np.arange(len(face))
        closed, groups = _rings(centre, face[rows, _AFTER[slot]], face[rows, _BEFORE[slot]], block)
        boundary[block] = ~closed
        for group in groups:
            found[group.around.shape[1]].append(group)
    return [_joined(groups, boundary) for groups in found.values() if groups]


def _joined(groups: list[Rings], boundary: NDArray[np.bool_]) -> Rings:
    """Return rings of one size in one; boundary: (p,) points that are on a boundary."""
    around = np.concatenate([group.around for group in groups])
    return Rings(
        vertex=np.concatenate([group.vertex for group in groups]),
        around=around,
        open=np.concatenate([group.open for group in groups]),
        boundary=boundary[around],
    )


def _rings(
    centre: IntArray, start: IntArray, end: IntArray, points: slice
) -> tuple[NDArray[np.bool_], list[Rings]]:
    """Return which of some points have one fan all about them, and the rings of those with one fan at all.

    centre: (n,) of each corner its point, counted from the first of `points`, rising; start, end: (n,) those of its
    face that follow. Which neighbours are on a boundary is left open.
    """
    count = points.stop - points.start
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
    rings = []
    for size in range(SMALLEST, LARGEST + 1):
        vertex = np.flatnonzero(good & (corners + ends == size))
        if len(vertex):
            around, whole = _walk(first[vertex], following, start, end, ends[vertex] == 1, size=size)
            vertex, around = vertex[whole], around[whole]
            if len(vertex):
                none = np.zeros((0, size), bool)
                rings.append(
                    Rings(
                        vertex=points.start + vertex,
                        around=around.astype(np.int32),
                        open=ends[vertex] == 1,
                        boundary=none,
                    )
                )
    return good & (ends == 0), rings


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

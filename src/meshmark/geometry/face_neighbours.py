"""The pairs of faces that share an edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.blocks import blocks
from meshmark.geometry.corners import corners_of_points
from meshmark.mesh import IntArray

__all__ = ["face_neighbours"]

# Points whose edges are looked at once: a table of all of a large model would take gigabytes meanwhile.
BLOCK = 1 << 16


def face_neighbours(
    faces: IntArray, count: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.bool_]]:
    """Return the two faces of every edge that belongs to two, and whether these turn against each other.

    Parameters
    ----------
    faces : (m, 3) int array
    count : int
        Number of points.

    Returns
    -------
    one, other : (e,) int32 array
    against : (e,) bool array
        Both faces run along the edge in the same direction.
    """
    lower = np.minimum(faces, faces[:, [1, 2, 0]])
    at, face_of, slot_of = corners_of_points(lower, count)
    del lower
    found = [(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0, bool))]
    for block in blocks(count, BLOCK):
        part = slice(at[block.start], at[block.stop])
        face, slot = face_of[part], slot_of[part]
        start, end = faces[face, slot], faces[face, (slot + 1) % 3]
        keys = (np.minimum(start, end) - block.start) * count + np.maximum(start, end)
        order = np.argsort(keys, kind="stable")
        _, first, times = np.unique(keys[order], return_index=True, return_counts=True)
        pairs = first[times == 2]
        one, other = order[pairs], order[pairs + 1]
        found.append((face[one], face[other], start[one] == start[other]))
    one, other, against = (np.concatenate(column) for column in zip(*found, strict=True))
    return one, other, against

"""The pairs of faces that share an edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import IntArray

__all__ = ["face_neighbours"]


def face_neighbours(faces: IntArray, count: int) -> tuple[IntArray, IntArray, NDArray[np.bool_]]:
    """Return the two faces of every edge that belongs to two, and whether these turn against each other.

    Parameters
    ----------
    faces : (m, 3) int array
    count : int
        Number of points.

    Returns
    -------
    one, other : (e,) int array
    against : (e,) bool array
        Both faces run along the edge in the same direction.
    """
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    keys = np.minimum(start, end) * count + np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    _, first, times = np.unique(keys[order], return_index=True, return_counts=True)
    pairs = first[times == 2]
    one, other = order[pairs], order[pairs + 1]
    return one // 3, other // 3, start[one] == start[other]

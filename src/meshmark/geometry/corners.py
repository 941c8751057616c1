"""The corners of faces by the points they lie at, in a table that takes little room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from meshmark.mesh import IntArray

__all__ = ["corners_of_points"]


def corners_of_points(points: IntArray, count: int) -> tuple[IntArray, NDArray[np.int32], NDArray[np.int8]]:
    """Return the corners of faces by the point that each has, in the order of the faces.

    Parameters
    ----------
    points : (m, 3) int array
        The point of each corner.
    count : int
        Number of points.

    Returns
    -------
    starts : (count + 1,) int array
        Where the corners of each point begin.
    face : (3 m,) int32 array
        The face of each corner.
    slot : (3 m,) int8 array
        Which corner of its face it is, 0 to 2.
    """
    slots = np.tile(np.arange(3, dtype=np.int8), len(points))
    starts = np.arange(0, points.size + 1, 3, dtype=np.int32)
    # From columns to rows: a counting sort.
    table = csc_array((slots, points.astype(np.int32).ravel(), starts), shape=(count, len(points))).tocsr()
    return table.indptr.astype(np.int64), table.indices, table.data

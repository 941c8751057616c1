"""Which points faces use, and the diagonal of the box around them: what sizes and budgets are relative to.

Points that no face uses say nothing of a surface, and one far away must not stretch what is allowed to it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["diagonal", "used_points"]


def used_points(faces: IntArray, count: int) -> NDArray[np.bool_]:
    """Return which of `count` points are used by `faces`.

    Parameters
    ----------
    faces : (m, 3) int array
        Indices of points.
    count : int
        Number of points.

    Returns
    -------
    (count,) bool array
    """
    used = np.zeros(count, dtype=bool)
    used[faces.ravel()] = True
    return used


def diagonal(points: FloatArray, faces: IntArray) -> float:
    """Return the diagonal of the bounding box of the points that `faces` use.

    Parameters
    ----------
    points : (p, 3) float array
        In any unit.
    faces : (m, 3) int array
        Indices of `points`, at least one face.

    Returns
    -------
    float
        In the unit of `points`.
    """
    return float(np.linalg.norm(np.ptp(points[used_points(faces, len(points))], axis=0)))

"""Cutting a surface into manifold pieces with one side each."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from meshmark.mesh import FloatArray, IntArray

__all__ = ["manifold_pieces"]


def manifold_pieces(points: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return points and faces of the same triangles, joined only where a manifold surface is joined.

    Two faces stay together along an edge that just these two walk, in opposite directions. Faces that met in any
    other way get copies of the points; so does a point where several fans met. Points of no face are left out.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    name = np.minimum(start, end) * len(points) + np.maximum(start, end)
    order = np.argsort(name, kind="stable")
    first = np.flatnonzero(np.diff(name[order], prepend=-1))
    two = first[np.diff(first, append=len(name)) == 2]
    one, other = order[two], order[two + 1]  # half edges, numbered as the corners that they leave
    opposed = start[one] == end[other]
    one, other = one[opposed], other[opposed]
    joined = np.stack([np.concatenate([one, _next(one)]), np.concatenate([_next(other), other])])
    corners = coo_array((np.ones(joined.shape[1], np.int8), tuple(joined)), shape=(len(start), len(start)))
    count, group = connected_components(corners, directed=False)
    place = np.empty(count, np.int64)
    place[group] = start
    return points[place], group.astype(np.int64).reshape(-1, 3)


def _next(corner: IntArray) -> IntArray:
    return corner - corner % 3 + (corner + 1) % 3

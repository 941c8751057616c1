"""Which nodes of a grid a surface encloses, from rays along the six axis directions.

Inside a closed surface every ray says the same. Where it has holes, or faces turned the wrong way, rays differ, and
their mean is a coarse generalised winding number (Jacobson et al. 2013, doi:10.1145/2461912.2461916).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.voxel_boxes import places_in_boxes
from meshmark.mesh import FloatArray, IntArray

__all__ = ["solid_nodes"]

ENOUGH = 4
"""Votes that make a node solid, of the 6 that all rays agree on inside a closed surface."""
PAIRS = 100_000
"""Pairs of triangle and grid line looked at together; bounds memory."""


def solid_nodes(points: FloatArray, faces: IntArray, shape: tuple[int, int, int]) -> NDArray[np.bool_]:
    """Return `shape`: whether each grid node (i, j, k) is inside.

    points: (p, 3) in voxels, inside the grid. A ray counts 1 for each face that it leaves the solid through and -1
    for each that it enters through. The two rays along an axis vote with their sum, limited to -2 and 2, so that
    one axis alone, looking through a hole, decides nothing; 4 votes of 6 make a node solid.
    """
    votes = np.zeros(shape, np.int8)
    for axis in range(3):
        steps = np.zeros(shape, np.int16)
        turned = np.roll(points, -axis, axis=1)  # the rays' own axis first, handedness kept
        for depth, line, sign in _crossings(turned, faces):
            node = np.roll(np.stack([np.ceil(depth).astype(np.int64), *line]), axis, axis=0)
            np.add.at(steps, tuple(node), sign)
        np.cumsum(steps, axis=axis, out=steps)
        every = np.take(steps, [-1], axis=axis)
        steps *= 2
        steps -= every
        votes += np.clip(steps, -2, 2, out=steps).astype(np.int8)
    solid: NDArray[np.bool_] = votes >= ENOUGH
    for axis, place in enumerate(points.T):  # nothing reaches beyond the surface's own box
        node = np.arange(shape[axis]).reshape([-1 if other == axis else 1 for other in range(3)])
        solid &= (node >= place.min()) & (node <= place.max())
    return solid


def _crossings(
    points: FloatArray, faces: IntArray
) -> Iterator[tuple[FloatArray, IntArray, NDArray[np.int16]]]:
    """Yield where grid lines along the first axis cross faces: depth (q,), line (2, q), 1 entering or -1 leaving.

    Each edge is tested the same way for both its faces, so a line never slips between them or hits both.
    """
    depth, flat = points[:, 0], points[:, 1:]
    for face, line in _pairs(flat[faces]):
        corners = faces[face].T
        sides = []
        for one, other in ((1, 2), (2, 0), (0, 1)):
            low, high = np.minimum(corners[one], corners[other]), np.maximum(corners[one], corners[other])
            a, b = flat[low].T, flat[high].T
            side = (b[0] - a[0]) * (line[1] - a[1]) - (b[1] - a[1]) * (line[0] - a[0])
            side[side == 0.0] = np.finfo(float).tiny
            sides.append(np.where(low == corners[one], side, -side))
        weights = np.stack(sides)
        front = np.asarray((weights > 0.0).all(axis=0))
        hit = np.flatnonzero(front | (weights < 0.0).all(axis=0))
        weights = weights[:, hit]
        weights /= weights.sum(axis=0)
        yield (
            (weights * depth[corners[:, hit]]).sum(axis=0),
            line[:, hit],
            np.where(front[hit], -1, 1).astype(np.int16),
        )


def _pairs(triangles: FloatArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Return triangle numbers (q,) and grid lines (2, q): all lines in the boxes of the triangles (t, 3, 2)."""
    return places_in_boxes(triangles.min(axis=1), triangles.max(axis=1), PAIRS)

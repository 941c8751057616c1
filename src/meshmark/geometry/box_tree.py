"""A tree of turned boxes around the triangles of a surface: how near can a group of faces be, at best?

Each box follows the principal axes of what it holds. Patches of surface are thin along their normal, and needles
along two axes, so such boxes tell near groups from others far better than balls or upright boxes would.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.blocks import blocks
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.point_triangle import Triangles
from meshmark.mesh import FloatArray, IntArray

__all__ = ["BRANCHES", "ROUNDING", "BoxLevel", "box_levels", "level_bounds"]

BRANCHES = 4
# Boxes are in single precision, which halves the time. The surface's extent is 1 to 2 here and that of its numbers
# no larger, so bounds err by less than this times the size of the query's coordinates.
ROUNDING = 4e-6


@dataclass(frozen=True, eq=False)
class BoxLevel:
    """The n boxes of one level; box j has the children BRANCHES j ... BRANCHES j + BRANCHES - 1 in the next.

    numbers: (n, 15) float32: axes as rows, the centre along them, half the lengths along them.
    large:   (n,) the face with the largest area in each box, a good guess at where its surface is.
    """

    numbers: NDArray[np.float32]
    large: IntArray

    def lower_bounds(self, queries: NDArray[Any], rows: IntArray, boxes: IntArray) -> NDArray[Any]:
        """Return (n,): the distance of the queries (3, q) of `rows` (n,) to the boxes (n,) beside them, 0 inside.

        Right but for `ROUNDING`. Queries of either precision; far ones need double, whose squares do not overflow.
        """
        out = np.empty(len(rows), queries.dtype)
        for part in blocks(len(rows), 1 << 13):
            q = queries.take(rows[part], axis=1)
            box = np.ascontiguousarray(self.numbers.take(boxes[part], axis=0).T)
            squared = np.zeros_like(q[0])
            for axis in range(3):
                beyond = q[0] * box[3 * axis]
                beyond += box[3 * axis + 1] * q[1]
                beyond += box[3 * axis + 2] * q[2]
                beyond -= box[9 + axis]
                np.abs(beyond, out=beyond)
                beyond -= box[12 + axis]
                np.maximum(beyond, 0.0, out=beyond)
                beyond *= beyond
                squared += beyond
            np.sqrt(squared, out=out[part])
        return out


def level_bounds(count: int, level: int) -> IntArray:
    """Return where the boxes of a level start among `count` ordered faces, and where the last one ends."""
    return np.asarray((count * np.arange(BRANCHES**level + 1)) // BRANCHES**level, np.int64)


def box_levels(triangles: Triangles) -> tuple[IntArray, list[BoxLevel]]:
    """Return an order of the faces that keeps neighbours together, and boxes around runs of it, coarse first.

    Each run has at least one face; those of the last level have at most BRANCHES.
    """
    middles = triangles.corner + (triangles.first + triangles.second) / 3.0
    order = np.asarray(kd_tree(middles, leafsize=BRANCHES).indices, np.int64)
    ordered = Triangles(
        corner=triangles.corner[order], first=triangles.first[order], second=triangles.second[order]
    )
    vectors = np.cross(ordered.first, ordered.second)
    areas = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    levels: list[BoxLevel] = []
    while len(order) >= BRANCHES ** len(levels):
        starts = level_bounds(len(order), len(levels))
        large = order[_largest(areas, starts)]
        levels.append(BoxLevel(_boxes(ordered, starts), large))
    return order, levels


def _largest(values: FloatArray, starts: IntArray) -> IntArray:
    """Return the place of the largest value in each run."""
    top = np.repeat(np.maximum.reduceat(values, starts[:-1]), np.diff(starts))
    places = np.flatnonzero(values == top)
    return places[np.searchsorted(places, starts[:-1])]


def _boxes(triangles: Triangles, starts: IntArray) -> NDArray[np.float32]:
    """Return the 15 numbers of a box around each run of triangles."""
    sizes = np.diff(starts)
    runs = np.repeat(np.arange(len(sizes)), sizes)
    corners = [triangles.corner, triangles.corner + triangles.first, triangles.corner + triangles.second]
    axes = _principal_axes(corners, starts)
    numbers = np.empty((len(sizes), 15), np.float32)
    numbers[:, :9] = axes.reshape(-1, 9)
    for i in range(3):
        along = axes[:, i].take(runs, axis=0)
        reach = [np.einsum("ij,ij->i", along, corner) for corner in corners]
        low = np.minimum.reduceat(np.minimum(np.minimum(*reach[:2]), reach[2]), starts[:-1])
        high = np.maximum.reduceat(np.maximum(np.maximum(*reach[:2]), reach[2]), starts[:-1])
        numbers[:, 9 + i] = 0.5 * (low + high)
        numbers[:, 12 + i] = 0.5 * (high - low)
    return numbers


def _principal_axes(corners: list[FloatArray], starts: IntArray) -> FloatArray:
    """Return (n, 3, 3): as rows, the eigenvectors of each run's scatter of corners about its mean."""
    count = 3.0 * np.diff(starts)
    mean = np.add.reduceat(sum(corners), starts[:-1]) / count[:, None]
    middle = np.repeat(mean, np.diff(starts), axis=0)
    scatter = np.zeros((len(count), 3, 3))
    apart = [corner - middle for corner in corners]
    for i in range(3):
        for j in range(i + 1):
            product = sum(x[:, i] * x[:, j] for x in apart)
            scatter[:, i, j] = scatter[:, j, i] = np.add.reduceat(product, starts[:-1])
    return np.ascontiguousarray(np.linalg.eigh(scatter).eigenvectors.transpose(0, 2, 1))

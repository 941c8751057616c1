"""The lattice nodes around points: which eight, and how far they are, in units of the spacing.

Nodes are told apart by one number each, so that a far outlier costs nothing but a few nodes of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["CORNERS", "REACH", "Surroundings", "find_nodes", "surroundings"]

# Nodes with coordinates below this; a canonical frame puts everything but outliers within a few hundred.
REACH = 1 << 19
_SIDE = 2 * REACH
# Nodes in the box about the points, over their number, of which there may be a table.
MOST_NODES = 128
CORNERS = tuple((i, j, k) for i, j, k in product((0, 1), repeat=3))


def _numbers(nodes: IntArray) -> IntArray:
    """Integer coordinates (n, 3) within the reach -> one number each (n,)."""
    i, j, k = (nodes + REACH).T
    return np.asarray((i * _SIDE + j) * _SIDE + k)


def _nodes(numbers: IntArray) -> IntArray:
    rest, k = np.divmod(numbers, _SIDE)
    i, j = np.divmod(rest, _SIDE)
    return np.column_stack([i, j, k]) - REACH


@dataclass(frozen=True, eq=False, kw_only=True)
class Surroundings:
    """The nodes around q points.

    nodes:    (n, 3) every node that is around some point.
    place:    (u, 8) for each different lattice cube and corner, the node's row in `nodes`.
    cube:     (q,) which cube each point is in; fraction: (3, q) where in it, in [0, 1).
    """

    nodes: IntArray
    place: IntArray
    cube: NDArray[np.int32]
    fraction: FloatArray

    def windows(self, part: slice) -> Iterator[FloatArray]:
        """Yield for each corner max(0, 1 - r^2) (part,) of the points to it."""
        fraction = self.fraction[:, part]
        near = fraction * fraction
        far = near - 2.0 * fraction + 1.0
        ends = near, far
        for i in (0, 1):
            one = 1.0 - ends[i][0]
            for j in (0, 1):
                two = one - ends[j][1]
                for end in ends:
                    three = two - end[2]
                    yield np.maximum(three, 0.0, out=three)


def surroundings(positions: FloatArray) -> Surroundings:
    """Return the nodes around positions (q, 3), all within the reach."""
    places = np.ascontiguousarray(
        positions.T
    )  # by coordinates, each in one piece, all of this is much faster
    whole = np.floor(places)
    fraction = np.subtract(places, whole, out=places if places.base is None else None)
    low = whole.min(axis=1, initial=REACH)
    across = whole.max(axis=1, initial=-REACH) - low + 2.0
    if float(np.prod(across)) > MOST_NODES * len(positions):
        return _far_apart(whole.T.astype(np.int64), fraction)
    # By a table of all nodes in the box about them: ten times faster than sorting.
    i, j, k = whole - low[:, None]
    x, y, z = across.astype(np.int64)
    name = ((i * across[1] + j) * across[2] + k).astype(np.int64)
    there = np.zeros(x * y * z, bool)
    there[name] = True
    cubes = np.flatnonzero(there)
    row = np.empty(len(there), np.int32)
    row[cubes] = np.arange(len(cubes), dtype=np.int32)
    cube = row.take(name)
    around = cubes[:, None] + np.array(CORNERS) @ np.array([y * z, z, 1])
    there[around] = True
    nodes = np.flatnonzero(there)
    row[nodes] = np.arange(len(nodes), dtype=np.int32)
    return Surroundings(
        nodes=np.stack(np.unravel_index(nodes, (x, y, z)), axis=1) + low.astype(np.int64),
        place=row.take(around).astype(np.int64),
        cube=cube,
        fraction=fraction,
    )


def _far_apart(base: IntArray, fraction: FloatArray) -> Surroundings:
    """Return the nodes around points in these cubes (q, 3), which are too far apart for a table of all between."""
    cubes, cube = np.unique(_numbers(base), return_inverse=True)
    around = cubes[:, None] + _numbers(np.array(CORNERS)) - _numbers(np.zeros((1, 3), np.int64))
    numbers, place = np.unique(around, return_inverse=True)
    return Surroundings(
        nodes=_nodes(numbers),
        place=place.reshape(around.shape),
        cube=cube.astype(np.int32),
        fraction=fraction,
    )


def find_nodes(known: IntArray, wanted: IntArray) -> IntArray:
    """Return for each of the `wanted` nodes (n, 3) its row in `known` (m, 3), or -1."""
    if not len(known):
        return np.full(len(wanted), -1, np.int64)
    numbers = _numbers(known)
    order = np.argsort(numbers)
    sought = _numbers(wanted)
    found = order[np.minimum(np.searchsorted(numbers, sought, sorter=order), len(known) - 1)]
    return np.where(numbers[found] == sought, found, -1)

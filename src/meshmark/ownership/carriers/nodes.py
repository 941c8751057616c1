"""The lattice nodes around points: which eight, and how far they are, in units of the spacing.

Nodes are told apart by one number each, so that a far outlier costs nothing but a few nodes of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["CORNERS", "REACH", "Surroundings", "find_nodes", "surroundings"]

# Nodes with coordinates below this; a canonical frame puts everything but outliers within a few hundred.
REACH = 1 << 19
_SIDE = 2 * REACH
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
    cube:     (q,) which cube each point is in; fraction: (q, 3) where in it, in [0, 1).
    """

    nodes: IntArray
    place: IntArray
    cube: IntArray
    fraction: FloatArray

    def windows(self, part: slice) -> Iterator[tuple[IntArray, FloatArray, IntArray]]:
        """Yield for each corner its coordinates (3,), max(0, 1 - r^2) (part,) and the nodes' rows (part,)."""
        fraction, cube = self.fraction[part], self.cube[part]
        near = (fraction * fraction).T.copy()
        far = near - 2.0 * fraction.T + 1.0
        for place, corner in zip(self.place.T, CORNERS, strict=True):
            x, y, z = ((far if bit else near)[axis] for axis, bit in enumerate(corner))
            yield np.array(corner), np.maximum(1.0 - x - y - z, 0.0), place.take(cube)


def surroundings(positions: FloatArray) -> Surroundings:
    """Return the nodes around positions (q, 3), all within the reach."""
    base = np.floor(positions).astype(np.int64)
    cubes, cube = _different(base)
    around = cubes[:, None] + _numbers(np.array(CORNERS)) - _numbers(np.zeros((1, 3), np.int64))
    numbers, place = np.unique(around, return_inverse=True)
    return Surroundings(
        nodes=_nodes(numbers), place=place.reshape(around.shape), cube=cube, fraction=positions - base
    )


def _different(base: IntArray) -> tuple[IntArray, IntArray]:
    """Return the numbers (u,) of different coordinates (q, 3), rising, and which one each has (q,)."""
    low = base.min(axis=0, initial=REACH)
    across = base.max(axis=0, initial=-REACH) - low + 1
    if float(np.prod(across.astype(np.float64))) > 16 * len(base):
        return np.unique(_numbers(base), return_inverse=True)
    # By a table of all that lie in the box about them: ten times faster.
    place = ((base[:, 0] - low[0]) * across[1] + base[:, 1] - low[1]) * across[2] + base[:, 2] - low[2]
    there = np.zeros(int(np.prod(across)), bool)
    there[place] = True
    found = np.column_stack(np.unravel_index(np.flatnonzero(there), tuple(across))) + low
    return _numbers(found), (np.cumsum(there) - 1)[place]


def find_nodes(known: IntArray, wanted: IntArray) -> IntArray:
    """Return for each of the `wanted` nodes (n, 3) its row in `known` (m, 3), or -1."""
    if not len(known):
        return np.full(len(wanted), -1, np.int64)
    numbers = _numbers(known)
    order = np.argsort(numbers)
    sought = _numbers(wanted)
    found = order[np.minimum(np.searchsorted(numbers, sought, sorter=order), len(known) - 1)]
    return np.where(numbers[found] == sought, found, -1)

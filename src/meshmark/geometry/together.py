"""Points so near to each other that rounding may make them one: they are made one beforehand."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from meshmark.geometry.components import connected_components
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray

__all__ = ["together"]

# Joined points may be near to others in turn; a chain of points longer than this many reaches is left alone.
_ROUNDS, _LONGEST = 3, 4.0


def together(points: FloatArray, reach: float) -> FloatArray:
    """Return points (p, 3); those that were within `reach` (scene units) of each other coincide in their mean.

    Points that have no other within reach stay where they are.
    """
    placed = points
    for _ in range(_ROUNDS):
        unique, of_point = np.unique(placed, axis=0, return_inverse=True)
        of_point = of_point.reshape(-1)
        pairs = kd_tree(unique).query_pairs(reach, output_type="ndarray")
        if not len(pairs):
            break
        graph = csr_array((np.ones(len(pairs), np.int8), pairs.T), shape=(len(unique), len(unique)))
        count, group = connected_components(graph)
        size = np.bincount(group)
        mean = np.stack([np.bincount(group, column) for column in unique.T], axis=1) / size[:, None]
        off = np.zeros(count)
        np.maximum.at(off, group, np.linalg.norm(unique - mean[group], axis=1))
        joined = (size > 1) & (off <= _LONGEST * reach)
        if not joined.any():
            break
        placed = np.where(joined[group][:, None], mean[group], unique)[of_point]
    return placed

"""Many changes in one check: places so far apart that each is judged as if it were alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.mesh import FloatArray, IntArray

__all__ = ["around", "directions", "far_apart"]


def around(graph: csr_array, point: int, steps: int) -> IntArray:
    """Return the points within this number of edges of a point."""
    found = np.array([point])
    for _ in range(steps):
        rows = [graph.indices[graph.indptr[each] : graph.indptr[each + 1]] for each in found]
        found = np.unique(np.concatenate([found, *rows]))
    return found


def far_apart(graph: csr_array, allowed: NDArray[np.bool_], edges: int, rng: np.random.Generator) -> IntArray:
    """Return points of `allowed` (p,) more than this number of edges apart, drawn one by one, as many as find room.

    What one of them shows within half as many edges is its own.
    """
    free = allowed.copy()
    chosen = []
    for point in rng.permutation(np.flatnonzero(allowed)).tolist():
        if free[point]:
            chosen.append(point)
            free[around(graph, point, edges)] = False
    return np.array(chosen, np.int64)


def directions(count: int, rng: np.random.Generator) -> FloatArray:
    """Return (count, 3) random unit vectors."""
    ways = rng.normal(size=(count, 3))
    return np.asarray(ways / np.linalg.norm(ways, axis=1)[:, None])

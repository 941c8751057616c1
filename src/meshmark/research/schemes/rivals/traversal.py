"""Every point of a mesh in the order of a search through it, breadth first."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from meshmark.mesh import IntArray

__all__ = ["traversal"]


def traversal(graph: csr_array, start: int) -> IntArray:
    """Return all points (p,) from `start` on, then the other parts of the model, each from its first point on."""
    count, part = connected_components(graph, directed=False)
    _, first = np.unique(part, return_index=True)
    first[part[start]] = start
    rows = [part[start], *(row for row in range(count) if row != part[start])]
    orders = [
        breadth_first_order(graph, first[row], directed=False, return_predecessors=False) for row in rows
    ]
    return np.concatenate(orders).astype(np.int64)

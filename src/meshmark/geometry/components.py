"""The connected components of a graph, by `scipy.sparse.csgraph`, which is imported with the first graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, csr_array

from meshmark.arrays import IntArray

__all__ = ["connected_components", "connected_parts"]


def connected_components(graph: csr_array | csc_array | coo_array) -> tuple[int, IntArray]:
    """Return how many components an undirected graph (n, n) has, and the number of each node's, (n,)."""
    from scipy.sparse import csgraph

    count, label = csgraph.connected_components(graph, directed=False)
    return int(count), np.asarray(label, np.int64)


def connected_parts(graph: csr_array, chosen: NDArray[np.bool_]) -> IntArray:
    """Return (n,): which connected part of the chosen nodes of a graph (n, n) each is in, -1 for the others."""
    rows = np.flatnonzero(chosen)
    part = np.full(len(chosen), -1)
    if len(rows):
        among = graph if len(rows) == len(chosen) else graph[rows][:, rows]
        part[rows] = connected_components(among)[1]
    return part

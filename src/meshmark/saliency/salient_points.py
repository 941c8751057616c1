"""Salient points: where beta exceeds every beta in the rings around it (paper algorithm 1, steps 9-10)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from meshmark.geometry.adjacency import ring_maximum
from meshmark.mesh import FloatArray, IntArray

__all__ = ["salient_points"]


def salient_points(beta: FloatArray, points: FloatArray, graph: csr_array, *, rings: int) -> IntArray:
    """Return the indices of the salient points, the strongest first.

    A point is salient where its beta exceeds every beta up to `rings` edges away and is not zero. Of equal
    betas the one with the larger (x, y, z) counts as larger, so the order of the file does not matter.

    Parameters
    ----------
    beta : (p,) array of float
        Saliency of each point.
    points : (p, 3) array of float
        Positions, for ties.
    graph : (p, p) sparse array
        Which points are neighbours.
    rings : int
        Number of edges within which a salient point is the strongest.

    Returns
    -------
    (k,) array of int
        Rows of `points`.
    """
    order = np.lexsort((*points.T[::-1], beta))
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    peaks = np.flatnonzero((ring_maximum(rank, graph, rings) == rank) & (beta > 0.0))
    return peaks[np.argsort(-rank[peaks])]

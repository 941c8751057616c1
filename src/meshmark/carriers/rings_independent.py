"""A keyed choice of points of which no two are neighbours, as many as can easily be had."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import FloatArray, IntArray

__all__ = ["independent_points"]


def independent_points(faces: IntArray, eligible: NDArray[np.bool_], chance: FloatArray) -> NDArray[np.bool_]:
    """Return (p,): a maximal set of `eligible` (p,) points without neighbours in it.

    Points with fewer undecided neighbours go first, which takes about 30 % of the points where a random order takes
    24 %; `chance` (p,) in [0, 1), keyed, decides between equals. Each round takes all points that come before all
    of their neighbours (Luby 1986, doi:10.1137/0215074, with an order that follows the front).
    """
    chosen = np.zeros(len(eligible), bool)
    edges = unique_edges(faces)
    edges = edges[eligible[edges].all(axis=1)]
    graph = adjacency(edges, len(eligible))
    left = eligible.copy()
    while left.any():
        start, end = edges.T
        degree = np.bincount(edges.ravel(), minlength=len(left)) + chance
        first = left.copy()
        earlier = degree[start] < degree[end]
        first[np.where(earlier, end, start)] = False
        chosen |= first
        gone = np.asarray(graph @ first.astype(np.float64)) > 0.0
        left &= ~(first | gone)
        edges = edges[left[edges].all(axis=1)]
    return chosen

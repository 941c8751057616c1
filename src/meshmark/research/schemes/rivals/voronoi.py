"""Salient points apart from each other, and the regions of the surface nearest to each, by lengths along edges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from meshmark.geometry.adjacency import adjacency
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.rivals.host import Host

__all__ = ["clusters", "edge_lengths", "regions"]


def edge_lengths(host: Host) -> csr_array:
    """Return (p, p): the length of each edge, at both its places."""
    graph = adjacency(host.edges, len(host.points))
    rows = np.repeat(np.arange(len(host.points)), np.diff(graph.indptr))
    steps = host.points[rows] - host.points[graph.indices]
    graph.data = np.maximum(np.linalg.norm(steps, axis=1), np.finfo(float).tiny)
    return graph


def clusters(
    lengths: csr_array, votes: FloatArray, radius: float, total: Callable[[FloatArray], float]
) -> tuple[IntArray, FloatArray]:
    """Return the row of the cluster of each point (p,), -1 for points without votes, and the total (k,) of each.

    The point with most votes takes those within `radius` along edges, then the next that is left; the rows are
    in the order of the totals of clusters' votes, most first.
    """
    cluster = np.full(len(votes), -1)
    sums: list[float] = []
    for point in np.argsort(-votes, kind="stable"):
        if votes[point] > 0.0 and cluster[point] < 0:
            near = dijkstra(lengths, indices=np.array([point]), limit=radius)[0] <= radius
            mine = near & (votes > 0.0) & (cluster < 0)
            cluster[mine] = len(sums)
            sums.append(float(total(votes[mine])))
    order = np.argsort(-np.array(sums), kind="stable")
    rank = np.append(np.argsort(order), -1)
    return rank[cluster], np.array(sums)[order]


def regions(host: Host, lengths: csr_array, cluster: IntArray) -> IntArray:
    """Return (p,): for each point the row of the cluster (p,), -1 for none, that is nearest along edges.

    A part of the model without a cluster goes to the one nearest through space.
    """
    seeds = np.flatnonzero(cluster >= 0)
    _, _, source = dijkstra(lengths, indices=seeds, min_only=True, return_predecessors=True)
    alone = source < 0
    found = np.where(alone, -1, cluster[np.where(alone, 0, source)])
    if alone.any():
        found[alone] = cluster[seeds[cKDTree(host.points[seeds]).query(host.points[alone])[1]]]
    return found

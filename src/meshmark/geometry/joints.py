"""Points that must move together, so that nothing cracks: near each other, or on an edge without being its end."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.components import connected_components
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.open_edges import open_edges
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray

__all__ = ["joints_of"]

# Points nearer than this share of the diagonal are one place.
NEAR = 2e-5
# Pairs of near points at most: a model with more is a cloud, in which nothing is joined.
MOST_PAIRS = 2_000_000
# Pairs of an open edge and a point beside it that are looked at together.
TOGETHER = 1_000_000
# A point on an edge follows points that may follow others: 2 to this power in a row, at most. Points of two borders
# along one line that lie near each other pass their motion on to and fro that often.
CHAIN = 24
# Weights per point at most, while that is worked out.
MOST_WEIGHTS = 400
# Weights below this are none.
LEAST = 1e-9


def joints_of(surface: Surface) -> sp.csr_array:
    """Return (p, p): rows say how each point follows others; joints @ motion is how all move.

    A point that follows none has a 1 of its own. Of points at one place all follow the first; a point inside an
    open edge, as at a T-junction, follows its ends by the place that it divides the edge at.

    Parameters
    ----------
    surface : Surface

    Returns
    -------
    csr_array
        With rows that sum to 1.
    """
    count = len(surface.points)
    tolerance = NEAR * surface.diagonal
    place = _places(surface.points, tolerance)
    first = np.full(place.max(initial=-1) + 1, count)
    np.minimum.at(first, place, np.arange(count))
    together = sp.csr_array((np.ones(count), (np.arange(count), first[place])), shape=(count, count))
    point, edge, share = _on_edges(surface, place, tolerance)
    point = first[place[point]]
    keep = np.unique(point, return_index=True)[1]
    point, edge, share = point[keep], edge[keep], share[keep]
    alone = np.ones(count)
    alone[point] = 0.0
    rows = np.concatenate([np.arange(count), point, point])
    columns = np.concatenate([np.arange(count), edge[:, 0], edge[:, 1]])
    values = np.concatenate([alone, 1.0 - share, share])
    follows = together @ sp.csr_array((values, (rows, columns)), shape=(count, count)) @ together
    follows.eliminate_zeros()
    for _ in range(CHAIN):
        if alone[follows.indices].all() or follows.nnz > MOST_WEIGHTS * count:
            break
        follows = follows @ follows
        follows.data[follows.data < LEAST] = 0.0
        # What is left out is shared by the others.
        follows = sp.diags_array(1.0 / follows.sum(axis=1)) @ follows
        follows.eliminate_zeros()
    return sp.csr_array(follows)


def _places(points: FloatArray, tolerance: float) -> IntArray:
    """Return (p,): the number of the place of each point."""
    pairs = kd_tree(points).query_pairs(tolerance, output_type="ndarray")
    if not len(pairs) or len(pairs) > MOST_PAIRS:
        return np.arange(len(points))
    graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    return connected_components(graph)[1]


def _on_edges(surface: Surface, place: IntArray, tolerance: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Return points (n,) inside open edges, these edges (n, 2), and where the points divide them."""
    points = surface.points
    # Edges that are open because their ends have two points at one place are none.
    start, end, _ = open_edges(place[surface.faces], len(points))
    first = np.full(len(points), len(points))
    np.minimum.at(first, place, np.arange(len(points)))
    start, end = first[start], first[end]
    at_border = np.unique(np.concatenate([start, end]))
    if not len(at_border):
        return at_border, np.zeros((0, 2), np.int64), np.zeros(0)
    tree = kd_tree(points[at_border])
    along = points[end] - points[start]
    length = np.linalg.norm(along, axis=1)
    middle, radius = points[start] + 0.5 * along, 0.5 * length + tolerance
    beside = np.cumsum(tree.query_ball_point(middle, radius, return_length=True))
    found = []
    for part in np.split(np.arange(len(start)), np.flatnonzero(np.diff(beside // TOGETHER)) + 1):
        near = tree.query_ball_point(middle[part], radius[part])
        edge = np.repeat(part, [len(each) for each in near])
        point = at_border[np.concatenate([np.asarray(each, dtype=np.int64) for each in near])]
        arm = points[point] - points[start[edge]]
        share = np.einsum("ij,ij->i", arm, along[edge]) / np.maximum(length[edge] ** 2, 1e-300)
        off = np.linalg.norm(arm - share[:, None] * along[edge], axis=1)
        margin = tolerance / np.maximum(length[edge], 1e-300)
        inside = (off < tolerance) & (share > margin) & (share < 1.0 - margin)
        found.append((point[inside], edge[inside], share[inside]))
    point, edge, share = (np.concatenate(column) for column in zip(*found, strict=True))
    return point, np.stack([start[edge], end[edge]], axis=1), share

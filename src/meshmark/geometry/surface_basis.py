"""Smooth functions on a surface: a partition of unity around nodes spread over it.

Each node has a compact kernel, (1 - r^2 / reach^2)^3 times the cosine between the normals where it is positive, so
that the two sides of a thin wall do not share functions; the kernels at a point are divided by their sum
(Shepard 1968, doi:10.1145/800186.810616).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.blocks import append, blocks
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray

__all__ = ["surface_basis"]

# Reach of a kernel over the distance of the nodes.
REACH = 2.1
# A point has its own node at least with this weight.
LEAST = 1e-6
# Points whose nodes are looked up at once: a table of them takes several times what is kept.
BLOCK = 1 << 15


def surface_basis(points: FloatArray, normals: FloatArray, pitch: float) -> sp.csr_array:
    """Return (p, m): the value at each point of each of m functions; each row adds up to 1.

    points: (p, 3); normals: (p, 3) unit; pitch: distance of the nodes, in the unit of `points`.
    """
    nodes, owner = _nodes(points, normals, pitch)
    tree = kd_tree(points[nodes])
    data, indices, counts = np.empty(0), np.empty(0, np.int32), np.empty(len(points), np.int32)
    for block in blocks(len(points), BLOCK):
        near = kd_tree(points[block]).sparse_distance_matrix(tree, REACH * pitch, output_type="ndarray")
        row, column = near["i"], near["j"]
        node = nodes[column]
        apart = points[block][row] - points[node]
        inside = np.maximum(1.0 - np.einsum("ij,ij->i", apart, apart) / (REACH * pitch) ** 2, 0.0)
        facing = np.maximum(np.einsum("ij,ij->i", normals[block][row], normals[node]), 0.0)
        value = inside**3 * facing
        some = np.flatnonzero(value > 0.0)
        count = block.stop - block.start
        rows = np.concatenate([row[some], np.arange(count)]).astype(np.int32)
        columns = np.concatenate([column[some], owner[block]]).astype(np.int32)
        values = np.concatenate([value[some], np.full(count, LEAST)])
        weights = sp.csr_array((values, (rows, columns)), shape=(count, len(nodes)))
        total = np.asarray(weights.sum(axis=1)).ravel()
        counts[block] = np.diff(weights.indptr)
        append(data, weights.data * np.repeat(1.0 / total, counts[block]))
        append(indices, weights.indices)
    starts = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
    return sp.csr_array((data, indices, starts), shape=(len(points), len(nodes)))


def _nodes(points: FloatArray, normals: FloatArray, pitch: float) -> tuple[IntArray, IntArray]:
    """Return one point (m,) of each occupied cube and main direction of the normal, and each point's node (p,)."""
    cubes = np.floor(points / pitch).astype(np.int64)
    cubes -= cubes.min(axis=0)
    sizes = cubes.max(axis=0) + 1
    side = np.argmax(np.abs(normals), axis=1)
    side = 2 * side + (np.take_along_axis(normals, side[:, None], axis=1)[:, 0] < 0.0)
    # Opposite sides of a thin wall lie in one cube; faces that meet at an angle may share a node.
    code = ((cubes[:, 0] * sizes[1] + cubes[:, 1]) * sizes[2] + cubes[:, 2]) * 6 + side
    _, owner = np.unique(code, return_inverse=True)
    count = int(owner.max()) + 1
    share = np.bincount(owner, minlength=count)
    centre = np.stack([np.bincount(owner, points[:, i], count) / share for i in range(3)], axis=1)
    away = ((points - centre[owner]) ** 2).sum(axis=1)
    order = np.lexsort((np.arange(len(points)), away, owner))
    first = np.flatnonzero(np.diff(owner[order], prepend=-1))
    return order[first], owner

"""Smooth functions on a surface: a partition of unity around nodes spread over it.

Each node has a compact kernel, (1 - r^2 / reach^2)^3 times the cosine between the normals where it is positive, so
that the two sides of a thin wall do not share functions; the kernels at a point are divided by their sum
(Shepard 1968, doi:10.1145/800186.810616).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.blocks import blocks
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray

__all__ = ["surface_basis"]

# Reach of a kernel over the distance of the nodes.
REACH = 2.1
# A point has its own node at least with this weight.
LEAST = 1e-6
# Nodes whose points are looked up at once: a table of them takes several times what is kept.
BLOCK = 256


def surface_basis(points: FloatArray, normals: FloatArray, pitch: float) -> sp.csr_array:
    """Return (p, m): the value at each point of each of m functions; each row adds up to 1.

    points: (p, 3); normals: (p, 3) unit; pitch: distance of the nodes, in the unit of `points`.
    """
    nodes, owner = _nodes(points, normals, pitch)
    owned = np.argsort(owner, kind="stable")  # the points by their nodes
    first = np.searchsorted(owner[owned], np.arange(len(nodes) + 1))
    tree, parts = kd_tree(points), []
    for block in blocks(len(nodes), BLOCK):
        near = kd_tree(points[nodes[block]]).sparse_distance_matrix(
            tree, REACH * pitch, output_type="ndarray"
        )
        row, column = near["j"], near["i"]
        node = nodes[block][column]
        apart = points[row] - points[node]
        inside = np.maximum(1.0 - np.einsum("ij,ij->i", apart, apart) / (REACH * pitch) ** 2, 0.0)
        facing = np.maximum(np.einsum("ij,ij->i", normals[row], normals[node]), 0.0)
        value = inside**3 * facing
        some = np.flatnonzero(value > 0.0)
        own = owned[first[block.start] : first[block.stop]]
        rows = np.concatenate([row[some], own]).astype(np.int32)
        columns = np.concatenate([column[some], owner[own] - block.start]).astype(np.int32)
        values = np.concatenate([value[some], np.full(len(own), LEAST)])
        shape = (len(points), block.stop - block.start)
        parts.append(sp.csc_array((values, (rows, columns)), shape=shape))
    weights = sp.hstack(parts, format="csc")
    parts.clear()  # before what is as large again
    weights = sp.csr_array(weights)
    total = np.asarray(weights.sum(axis=1)).ravel()
    weights.data *= np.repeat(1.0 / total, np.diff(weights.indptr))
    return weights


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

"""Principal curvatures of a mesh at a chosen radius, from how much the edges within a sphere bend.

The tensor at a point is the sum over edges of beta |e in sphere| e e^T / (pi r^2), where e is the unit vector of an
edge and beta the signed angle between its two faces (Cohen-Steiner and Morvan 2003, 10.1145/777792.777812).
A surface bends across its edges; the two largest eigenvalues in magnitude are the principal curvatures either way.
"""

from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import area_vectors
from meshmark.geometry.growth import Growth, HalfEdges, grow_all
from meshmark.mesh import FloatArray, IntArray

__all__ = ["bends", "principal_curvatures"]


def bends(points: FloatArray, faces: IntArray, graph: HalfEdges) -> FloatArray:
    """Return (e,): the signed angle between the two faces of each edge of `graph.edges`, -pi/2 to pi/2.

    It is the arc sine of the triple product, as in the reference values of MSDM2: a fold by more than a right angle
    counts as its supplement. Positive or negative for ridges and valleys of an oriented surface; 0 where an
    edge has not exactly two faces; NaN beside a face without area, whose normal is unknown.
    """
    normals = area_vectors(points, faces)
    lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    normals /= np.where(lengths > 0.0, lengths, np.nan)[:, None]
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    proper = np.flatnonzero(start != end)
    face, start, end = proper // 3, start[proper], end[proper]
    edge = _edge_numbers(graph.edges, start, end, len(points))
    order = np.argsort(edge, kind="stable")
    first = np.searchsorted(edge[order], np.arange(len(graph.edges)))
    two = np.flatnonzero(np.bincount(edge, minlength=len(graph.edges)) == 2)
    one, other = order[first[two]], order[first[two] + 1]
    left, right = normals[face[one]], normals[face[other]]
    right = np.where(
        (start[one] == start[other])[:, None], -right, right
    )  # turned over against its neighbour
    along = points[end[one]] - points[start[one]]
    along /= np.sqrt(np.einsum("ij,ij->i", along, along))[:, None]
    out = np.zeros(len(graph.edges))
    out[two] = np.arcsin(np.clip(np.einsum("ij,ij->i", np.cross(left, right), along), -1.0, 1.0))
    out[edge[lengths[face] == 0.0]] = np.nan
    return out


def _edge_numbers(edges: IntArray, start: IntArray, end: IntArray, count: int) -> IntArray:
    """Return the row of `edges`, which are sorted, that joins each pair of points."""
    keys = edges[:, 0] * count + edges[:, 1]
    return np.asarray(np.searchsorted(keys, np.minimum(start, end) * count + np.maximum(start, end)))


def principal_curvatures(
    points: FloatArray, faces: IntArray, graph: HalfEdges, radii: tuple[float, ...]
) -> FloatArray:
    """Return (k, p, 2): for each of k radii Kmax and Kmin at each point, in 1 / unit of length.

    Kmax is the larger in magnitude; both signs are flipped where it would be negative. Both are 0 where a face
    without area spoils the tensor and where no edge starts.
    """
    angles = bends(points, faces, graph)
    out = np.zeros((len(radii), len(points), 2))
    for growth in grow_all(points, graph, np.arange(len(points)), max(radii)):
        for level, radius in enumerate(radii):
            tensors = _tensors(growth, graph, angles, radius)
            out[level, growth.centres] = _two_largest(tensors)
    return out


def _tensors(growth: Growth, graph: HalfEdges, angles: FloatArray, radius: float) -> FloatArray:
    """Return (c, 3, 3): the tensor of each centre."""
    used = np.flatnonzero(growth.near <= radius * radius)
    half_edge, owner = growth.half_edge.take(used), growth.edge_owner.take(used)
    share = np.ones(len(used))
    leaving = np.flatnonzero(growth.far.take(used) > radius * radius)
    share[leaving] = growth.crossing(graph, radius, used.take(leaving))
    share *= angles.take(graph.edge.take(half_edge))
    share /= np.sqrt(graph.squares.take(half_edge)) * (np.pi * radius * radius)
    vector = graph.vectors.take(half_edge, axis=0).T
    out = np.empty((len(growth.centres), 3, 3))
    for i in range(3):
        for j in range(i + 1):
            entry = np.bincount(owner, share * vector[i] * vector[j], minlength=len(growth.centres))
            out[:, i, j] = out[:, j, i] = entry
    return out


def _two_largest(tensors: FloatArray) -> FloatArray:
    """Return (c, 2): the eigenvalues largest in magnitude, the first not negative; 0 for failed tensors."""
    known = np.asarray(np.isfinite(tensors).all(axis=(1, 2)))
    values = np.linalg.eigvalsh(np.where(known[:, None, None], tensors, 0.0))
    order = np.argsort(-np.abs(values), axis=1)[:, :2]
    values = np.take_along_axis(values, order, axis=1)
    return np.asarray(np.where(values[:, :1] < 0.0, -values, values))

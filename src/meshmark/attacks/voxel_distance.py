"""Distance from the nodes of a grid to a triangle surface, exact near it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.voxel_boxes import places_in_boxes
from meshmark.mesh import FloatArray, IntArray

__all__ = ["band_distance", "split_triangles"]

PAIRS = 100_000
"""Pairs of node and triangle looked at together; bounds memory."""
LONGEST = 4.0
"""Triangles are cut into pieces no longer than this, in voxels, so that their boxes hold few far nodes."""


def band_distance(triangles: FloatArray, shape: tuple[int, int, int], band: float) -> NDArray[np.float32]:
    """Return `shape`: the distance of each grid node (i, j, k) to the nearest triangle, at most `band`.

    triangles: (t, 3, 3) corners in voxels, short as `split_triangles` returns them, in the grid with their bands.
    """
    distance = np.full(shape, band * band, np.float32)
    flat = distance.reshape(-1)
    a, b, c = triangles.transpose(1, 2, 0)
    normal = np.cross(b - a, c - a, axis=0)
    normal /= np.maximum(np.sqrt((normal**2).sum(axis=0)), np.finfo(float).tiny)
    for triangle, node in _pairs(triangles, band):
        step = node - a[:, triangle]
        height = (step * normal[:, triangle]).sum(axis=0)
        near = np.flatnonzero(np.abs(height) < band)
        triangle, node = triangle[near], node[:, near]
        square = _squared_distance(node, a[:, triangle], b[:, triangle], c[:, triangle])
        name = (node[0] * shape[1] + node[1]) * shape[2] + node[2]
        np.minimum.at(flat, name, square.astype(np.float32))
    return np.sqrt(distance, out=distance)


def split_triangles(triangles: FloatArray) -> FloatArray:
    """Cut triangles (t, 3, 3) into similar pieces none of whose edges is longer than `LONGEST`."""
    edge = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    pieces = np.maximum(np.ceil(edge / LONGEST), 1).astype(np.int64)
    parts = [triangles[pieces == 1]]
    for count in np.unique(pieces[pieces > 1]):
        corners = np.einsum("qcw,twx->tqcx", _pattern(int(count)), triangles[pieces == count])
        parts.append(corners.reshape(-1, 3, 3))
    return np.concatenate(parts)


def _pattern(count: int) -> FloatArray:
    """Barycentric corners (count^2, 3, 3) of a triangle cut into count^2 equal ones."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    corner = np.stack([i, j], axis=1)[:, None]
    up = corner[i + j < count] + np.array([[0, 0], [1, 0], [0, 1]])
    down = corner[i + j < count - 1] + np.array([[1, 1], [0, 1], [1, 0]])
    two = np.concatenate([up, down]) / count
    return np.concatenate([1.0 - two.sum(axis=2, keepdims=True), two], axis=2)


def _pairs(triangles: FloatArray, band: float) -> Iterator[tuple[IntArray, IntArray]]:
    """Return triangle numbers (q,) and nodes (3, q): all nodes in the triangles' boxes with their bands."""
    return places_in_boxes(triangles.min(axis=1) - band, triangles.max(axis=1) + band, PAIRS)


def _squared_distance(p: IntArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Squared distances (q,) of points to triangles, coordinates (3, q)."""
    ab, ac, ap = b - a, c - a, p - a
    d00, d01, d11 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d20, d21, pp = _dot(ap, ab), _dot(ap, ac), _dot(ap, ap)
    area = np.maximum(d00 * d11 - d01 * d01, 0.0)
    v, w = d11 * d20 - d01 * d21, d00 * d21 - d01 * d20  # barycentric coordinates times `area`
    inside = (v > 0.0) & (w > 0.0) & (v + w < area)
    best = np.minimum(_to_segment(pp, d20, d00), _to_segment(pp, d21, d11))
    on_third = _to_segment(pp - 2.0 * d20 + d00, d21 - d20 + d00 - d01, d00 + d11 - 2.0 * d01)
    np.minimum(best, on_third, out=best)
    safe = np.where(inside, area, 1.0)
    plane = pp - (v * d20 + w * d21) / safe
    return np.asarray(np.maximum(np.where(inside, np.minimum(plane, best), best), 0.0))


def _to_segment(pp: FloatArray, along: FloatArray, length: FloatArray) -> FloatArray:
    """Squared distance to a segment from |p|^2, p . s and |s|^2, p and s taken from its start."""
    place = np.clip(along / np.maximum(length, np.finfo(float).tiny), 0.0, 1.0)
    return np.asarray(pp + place * (place * length - 2.0 * along))


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(one[0] * other[0] + one[1] * other[1] + one[2] * other[2])

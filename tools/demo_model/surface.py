"""From a signed distance to a closed mesh of well-shaped triangles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from demo_model.solids import Array

Faces = NDArray[np.int64]
Solid = Callable[[Array], Array]


def extract(solid: Solid, low: Array, high: Array, cell: float) -> tuple[Array, Faces]:
    """Return the surface of a solid inside a box by surface nets: a vertex per grid cell that it crosses."""
    counts = np.ceil((high - low) / cell).astype(int) + 1
    axes = [low[k] + cell * np.arange(counts[k]) for k in range(3)]
    inside = _inside(solid, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1), cell)
    corners = [
        inside[a : counts[0] - 1 + a, b : counts[1] - 1 + b, c : counts[2] - 1 + c]
        for a, b, c in np.ndindex(2, 2, 2)
    ]
    full = np.sum(corners, axis=0)
    crossed = (full > 0) & (full < 8)
    number = np.full(crossed.shape, -1)
    number[crossed] = np.arange(crossed.sum())
    vertices = low + cell * (np.argwhere(crossed) + 0.5)
    quads = []
    for axis in range(3):
        near = inside.take(range(counts[axis] - 1), axis)
        change = near != inside.take(range(1, counts[axis]), axis)
        at = np.argwhere(change)
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        ring = np.stack(
            [number[tuple((at - du * u - dv * v).T)] for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0))], 1
        )
        ring[~near[tuple(at.T)]] = ring[~near[tuple(at.T)], ::-1]
        quads.append(ring)
    quad = np.concatenate(quads)
    return vertices, np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])


def _inside(solid: Solid, grid: Array, cell: float) -> NDArray[np.bool_]:
    """Return which grid points lie in the solid; only those near its surface are looked at one by one."""
    stride = 4
    coarse = solid(grid[::stride, ::stride, ::stride])
    value = coarse
    for axis in range(3):
        value = value.repeat(stride, axis).take(range(grid.shape[axis]), axis)
    near = np.abs(value) < 5 * stride * cell
    value[near] = solid(grid[near])
    return value < 0.0


def gradient(solid: Solid, p: Array, step: float) -> Array:
    """Return the unit gradient of a signed distance, (n, 3), by differences over a tetrahedron."""
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    out = sum(solid(p + step * corner)[:, None] * corner for corner in corners)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)


def settle(solid: Solid, vertices: Array, faces: Faces, cell: float, rounds: int) -> tuple[Array, Faces]:
    """Even out the triangles: flip edges, move vertices along the surface, put them back on it."""
    for turn in range(rounds):
        if turn % 3 == 2:
            faces = flipped(vertices, faces)
        normals = gradient(solid, vertices, 0.1 * cell)
        pull = _centres(vertices, faces) - vertices
        pull -= np.sum(pull * normals, axis=1, keepdims=True) * normals
        vertices = vertices + 0.7 * pull
        vertices = vertices - np.clip(solid(vertices), -cell, cell)[:, None] * normals
    return vertices, flipped(vertices, faces)


def flipped(vertices: Array, faces: Faces) -> Faces:
    """Return the triangles after flipping, once each, the edges that face more than 180 degrees together."""
    faces = faces.copy()
    opposite: dict[tuple[int, int], tuple[int, int]] = {}
    for f, triangle in enumerate(faces.tolist()):
        for k in range(3):
            opposite[triangle[k], triangle[(k + 1) % 3]] = f, triangle[(k + 2) % 3]
    linked = defaultdict(set)
    for a, b in opposite:
        linked[a].add(b)
    touched: set[int] = set()
    for a, b in [edge for edge in opposite if edge[0] < edge[1]]:
        (f, c), (g, d) = opposite[a, b], opposite[b, a]
        if f in touched or g in touched or d in linked[c] or len(linked[a]) < 5 or len(linked[b]) < 5:
            continue
        if _cosine(vertices, c, a, b) + _cosine(vertices, d, a, b) < -1e-3:
            faces[f], faces[g] = (c, a, d), (d, b, c)
            touched |= {f, g}
            linked[a].discard(b), linked[b].discard(a), linked[c].add(d), linked[d].add(c)
    return faces


def _cosine(vertices: Array, apex: int, a: int, b: int) -> float:
    u, v = vertices[a] - vertices[apex], vertices[b] - vertices[apex]
    return float(u @ v / np.sqrt((u @ u) * (v @ v)))


def _centres(vertices: Array, faces: Faces) -> Array:
    """Return the area-weighted mean of the centres of the triangles at each vertex."""
    corner = vertices[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    centre = corner.mean(axis=1) * area[:, None]
    total, weight = np.zeros_like(vertices), np.zeros(len(vertices))
    for k in range(3):
        np.add.at(total, faces[:, k], centre)
        np.add.at(weight, faces[:, k], area)
    return total / weight[:, None]

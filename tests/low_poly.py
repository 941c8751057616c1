"""Coarse models made by code, with flat sides, straight edges and corners, for tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from meshmark.mesh import FloatArray, IntArray, Mesh

Parts = tuple[FloatArray, IntArray]


def joined(parts: Sequence[Parts]) -> Parts:
    """Return several surfaces as one, without welding anything."""
    starts = np.cumsum([0] + [len(points) for points, _ in parts])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(faces)


def welded(parts: Parts) -> Parts:
    """Return a surface whose points that are equal up to rounding are one."""
    points, faces = parts
    _, first, row = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return points[first], row.ravel()[faces]


def ticks(count: int, seed: int) -> FloatArray:
    """Return where `count` pieces of an edge from 0 to 1 begin and end, unevenly."""
    inner = (np.arange(1, count) + 0.25 * np.random.default_rng(seed).uniform(-1.0, 1.0, count - 1)) / count
    return np.concatenate([[0.0], inner, [1.0]])


def sheet(across: FloatArray, up: FloatArray, *, other: bool = False) -> Parts:
    """Return the unit square in z = 0, facing +z, cut at these places; other: along the other diagonals."""
    x, y = np.meshgrid(across, up, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    here = np.arange(x.size).reshape(x.shape)
    a, b, c, d = here[:-1, :-1], here[1:, :-1], here[1:, 1:], here[:-1, 1:]
    halves = ((a, b, d), (b, c, d)) if other else ((a, b, c), (a, c, d))
    return points, np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in halves])


def sides(counts: Sequence[int], *, other: bool = False) -> list[Parts]:
    """Return the six sides of the unit cube, facing outwards, cut unevenly into so many pieces along each axis."""
    cuts = [ticks(count, axis) for axis, count in enumerate(counts)]
    found = []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        flat, faces = sheet(cuts[one], cuts[two], other=other)
        for end in (0.0, 1.0):
            points = np.empty_like(flat)
            points[:, one], points[:, two], points[:, axis] = flat[:, 0], flat[:, 1], end
            found.append((points, faces if end else faces[:, ::-1]))
    return found


def box(
    counts: Sequence[int], size: Sequence[float], low: Sequence[float] = (0.0, 0.0, 0.0), **more: bool
) -> Parts:
    """Return a watertight box of a size with its lowest corner there, cut unevenly."""
    points, faces = welded(joined(sides(counts, **more)))
    return points * size + low, faces


def table() -> Parts:
    """Return a table: a board and four legs that stand apart from it, each a watertight box."""
    legs = [box((2, 2, 5), (0.1, 0.12, 0.8), (x, y, 0.0)) for x in (0.05, 1.6) for y in (0.05, 0.85)]
    return joined([box((8, 6, 1), (1.8, 1.05, 0.08), (0.0, 0.0, 0.81)), *legs])


def prism(around: int, rows: int, height: float) -> Parts:
    """Return a closed round prism of radius 1: the second moments across it are equal."""
    turn = 2.0 * np.pi * np.arange(around) / around
    level = height * ticks(rows, 5)
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = np.concatenate([np.column_stack([rim, np.full(around, z)]) for z in level])
    here = np.arange(len(points)).reshape(rows + 1, around)
    right = np.roll(here, -1, axis=1)
    a, b, c, d = here[:-1], right[:-1], right[1:], here[1:]
    walls = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in ((a, b, c), (a, c, d))])
    ends = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, height]])
    low, high = len(points), len(points) + 1
    caps = [
        np.stack([np.full(around, low), right[0], here[0]], axis=1),
        np.stack([np.full(around, high), here[-1], right[-1]], axis=1),
    ]
    return np.concatenate([points, ends]), np.concatenate([walls, *caps])


def ball(times: int) -> Parts:
    """Return an icosahedron, its faces split into four `times` times and its points put on a lopsided ball."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    points = np.array([[a, b, 0.0] for a in (-1.0, 1.0) for b in (-golden, golden)])
    points = np.concatenate([np.roll(points, shift, axis=1) for shift in range(3)])
    gaps = np.linalg.norm(points[:, None] - points, axis=2) < 2.1
    faces = np.array(
        [
            [i, j, k]
            for i in range(12)
            for j in range(i)
            for k in range(j)
            if gaps[i, j] and gaps[j, k] and gaps[i, k]
        ]
    )
    normal = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    inward = np.einsum("ij,ij->i", normal, points[faces[:, 0]]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    for _ in range(times):
        points, faces = subdivided((points, faces))
    unit = points / np.linalg.norm(points, axis=1)[:, None]
    x, y, z = unit.T
    return unit * (1.0 + 0.2 * x + 0.1 * x * y + 0.15 * z**3)[:, None] * [1.5, 1.2, 1.0], faces


def subdivided(parts: Parts) -> Parts:
    """Return a surface whose faces are split into four at the middles of their edges; what it had comes first."""
    points, faces = parts
    ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    edges, row = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    ab, bc, ca = (row.reshape(-1, 3) + len(points)).T
    a, b, c = faces.T
    split = np.concatenate(
        [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return np.concatenate([points, points[edges].mean(axis=1)]), split


def soup(mesh: Mesh) -> Mesh:
    """Return a mesh of which every face has vertices of its own."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))


def loose_box() -> Parts:
    """Return a box of six sides that are cut each in its own way: their points lie inside the edges of others."""
    found = []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        for end in (0.0, 1.0):
            seed = 10 * axis + int(end)
            flat, faces = sheet(ticks(4 + axis, seed), ticks(5 + int(end), seed + 5))
            points = np.empty_like(flat)
            points[:, one], points[:, two], points[:, axis] = flat[:, 0], flat[:, 1], end
            found.append((points * [3.0, 2.0, 1.3], faces if end else faces[:, ::-1]))
    return joined(found)


def frustum() -> Parts:
    """Return a box that is narrower on top: its walls lie askew to the axes of its frame."""
    points, faces = box((6, 5, 4), (3.0, 2.0, 1.3))
    middle = np.array([1.5, 1.0, 0.0])
    narrower = 1.0 - 0.25 * points[:, 2:]
    return (points - middle) * np.column_stack([narrower, narrower, np.ones(len(points))]) + middle, faces

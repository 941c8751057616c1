"""A shape made by formula, for benchmarks that come without models."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import Mesh

__all__ = ["lopsided"]


def lopsided(across: int) -> Mesh:
    """Return a closed, smooth shape with dents, of about across^2 / 2 vertices; its frame is well defined."""
    turn = 2.0 * np.pi * np.arange(across) / across
    rise = np.pi * np.arange(1, across // 2) / (across // 2)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(across)], axis=1)
    sides = (np.sin(rise)[:, None, None] * ring + np.cos(rise)[:, None, None] * [0.0, 0.0, 1.0]).reshape(
        -1, 3
    )
    unit = np.concatenate([sides, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    x, y, z = unit.T
    radius = (
        1.0
        + 0.2 * x
        + 0.14 * x * y
        + 0.22 * z**3
        + 0.07 * np.sin(5.0 * y) * x
        + 0.06 * np.cos(4.0 * z + 2.0 * x)
    )
    return Mesh(unit * radius[:, None] * [1.7, 1.2, 1.0], _sphere_faces(across, len(rise)))


def _sphere_faces(across: int, rings: int) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    """Return the triangles between rings of vertices, then the two caps, seen anticlockwise from outside."""
    here = np.arange((rings - 1) * across).reshape(-1, across)
    right = np.roll(here, -1, axis=1)
    below, below_right = here + across, right + across
    bands = [
        np.stack(part, axis=-1).reshape(-1, 3) for part in ((here, below, right), (right, below, below_right))
    ]
    first, last = np.arange(across), np.arange(across) + (rings - 1) * across
    top = np.stack([np.full(across, rings * across), first, np.roll(first, -1)], axis=1)
    bottom = np.stack([np.full(across, rings * across + 1), np.roll(last, -1), last], axis=1)
    return np.concatenate([*bands, top, bottom])

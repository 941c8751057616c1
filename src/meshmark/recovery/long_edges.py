"""Splitting of long edges, so that a miniature's faces become as small as those around them."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import unique_edges
from meshmark.mesh import FloatArray, IntArray

__all__ = ["split_long_edges"]

ROUNDS, MOST_FACES = 12, 400_000


def split_long_edges(points: FloatArray, faces: IntArray, longest: float) -> tuple[FloatArray, IntArray]:
    """Return the same surface with its edges halved until none is longer than `longest`, or faces are very many."""
    for _ in range(ROUNDS):
        edges = unique_edges(faces)
        split = edges[((points[edges[:, 0]] - points[edges[:, 1]]) ** 2).sum(axis=1) > longest**2]
        if not len(split) or len(faces) > MOST_FACES:
            break
        key = split[:, 0] * len(points) + split[:, 1]  # sorted, as the edges are
        low = np.minimum(faces, faces[:, [1, 2, 0]])
        high = np.maximum(faces, faces[:, [1, 2, 0]])
        sides = low * len(points) + high
        place = np.minimum(np.searchsorted(key, sides), len(key) - 1)
        middle = np.where(key[place] == sides, len(points) + place, -1)
        points = np.concatenate([points, 0.5 * (points[split[:, 0]] + points[split[:, 1]])])
        faces = _parts(points, faces, middle)
    return points, faces


def _parts(points: FloatArray, faces: IntArray, middle: IntArray) -> IntArray:
    """Return the faces, split at the middles (m, 3) of their sides 0-1, 1-2, 2-0; -1 where a side stays whole."""
    number = (middle >= 0).sum(axis=1)
    # Turned so that of one split side it is the first, and of two the third is whole.
    turn = np.where(number == 1, np.argmax(middle >= 0, axis=1), 0)
    turn = np.where(number == 2, (np.argmax(middle < 0, axis=1) + 1) % 3, turn)
    order = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, order, axis=1).T
    x, y, z = np.take_along_axis(middle, order, axis=1).T
    one, two, three = number == 1, number == 2, number == 3
    parts = [faces[number == 0]]
    parts += [np.stack(corners, axis=1)[one] for corners in ((a, x, c), (x, b, c))]
    # Of two split sides, a-b and b-c, the rest is a quadrangle a, x, y, c: cut along its shorter diagonal.
    short = ((points[a] - points[y]) ** 2).sum(axis=1) < ((points[x] - points[c]) ** 2).sum(axis=1)
    parts += [np.stack([x, b, y], axis=1)[two]]
    parts += [np.stack(corners, axis=1)[two & short] for corners in ((a, x, y), (a, y, c))]
    parts += [np.stack(corners, axis=1)[two & ~short] for corners in ((a, x, c), (x, y, c))]
    parts += [np.stack(corners, axis=1)[three] for corners in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))]
    return np.concatenate(parts)

"""Border loops of a surface, and strips of faces between two of them."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["border_edges", "fan", "loops", "strip"]

# How far one side of a strip may run ahead of the other, as a share of the whole.
AHEAD = 0.1


def border_edges(faces: IntArray) -> IntArray:
    """Return (b, 2): the directed edges, as their faces walk them, that no face walks the other way."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    count = int(faces.max(initial=0)) + 1
    forward, backward = start * count + end, end * count + start
    alone = ~np.isin(forward, backward)
    return np.stack([start[alone], end[alone]], axis=1)


def loops(edges: IntArray) -> list[IntArray]:
    """Return the closed walks that directed edges (b, 2) make up, each point once; broken walks are left out.

    Where walks meet in a point they part there, so that each is simple.
    """
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(start, []).append(end)
    found = []
    while following:
        walk: list[int] = []
        place: dict[int, int] = {}
        point = next(iter(following))
        while True:
            if point in place:
                found.append(np.array(walk[place[point] :], np.int64))
                for passed in walk[place[point] :]:
                    del place[passed]
                walk = walk[: len(walk) - len(found[-1])]
            place[point] = len(walk)
            walk.append(point)
            if point not in following:
                break
            ends = following[point]
            nearest = ends.pop()
            if not ends:
                del following[point]
            point = nearest
    return [walk for walk in found if len(walk) >= 3]


def fan(loop: IntArray, middle: int) -> IntArray:
    """Return faces from each edge of a closed walk (k,) to the point `middle`."""
    return np.stack([loop, np.roll(loop, -1), np.full(len(loop), middle)], axis=1)


def strip(one: FloatArray, other: FloatArray, closed: bool) -> IntArray:
    """Return faces between two walks of points (a, 3) and (b, 3) that run alongside; the second has numbers from a.

    Each face has an edge of one walk and a point of the other; edges of the first are walked forwards, of the
    second backwards. Closed walks must start at points that belong together.
    """
    first, second = _closed(one, closed), _closed(other, closed)
    along, beside = _progress(first), _progress(second)
    faces, i, j = [], 0, 0
    while i + 1 < len(first) or j + 1 < len(second):
        if j + 1 == len(second):
            step = True
        elif i + 1 == len(first):
            step = False
        elif abs(along[i + 1] - beside[j + 1]) > AHEAD:
            step = bool(along[i + 1] < beside[j + 1])
        else:
            step = bool(((first[i + 1] - second[j]) ** 2).sum() <= ((first[i] - second[j + 1]) ** 2).sum())
        if step:
            faces.append((i % len(one), (i + 1) % len(one), len(one) + j % len(other)))
            i += 1
        else:
            faces.append((i % len(one), len(one) + (j + 1) % len(other), len(one) + j % len(other)))
            j += 1
    return np.array(faces, np.int64).reshape(-1, 3)


def _closed(walk: FloatArray, closed: bool) -> FloatArray:
    return np.concatenate([walk, walk[:1]]) if closed else walk


def _progress(walk: FloatArray) -> FloatArray:
    steps = np.sqrt((np.diff(walk, axis=0) ** 2).sum(axis=1))
    total = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(total / max(float(total[-1]), np.finfo(float).tiny))

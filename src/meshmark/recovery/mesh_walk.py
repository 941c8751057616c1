"""The walk over a small mesh that both sides of its coding take: faces are crossed edge by edge."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.range_coder import Model

__all__ = ["MeshWalk", "WalkModels"]

# Distance of the nearest known point from the predicted place, in edge lengths: contexts of the models.
NEAR = (0.35, 0.6, 0.9, 1.3)
LENGTHS = 18
KINDS = [[1, 2, 30], [1, 8, 16], [1, 16, 8], [1, 24, 4], [1, 30, 2]]
MOST_POINTS = 60_000


class WalkModels:
    """The models of both sides; they learn alike."""

    def __init__(self, bits: int) -> None:
        self.kind = [Model(first) for first in KINDS]
        self.rank = [Model([40, 8, 4, 2, 1, 1, 1, 1]) for _ in KINDS]
        self.more = Model([2, 1])
        likely = [1 + 12 * max(0, 3 - abs(length - (bits - 3))) for length in range(LENGTHS)]
        self.length = [Model(likely) for _ in range(3)]
        self.high = [[Model([1, 1]) for _ in range(LENGTHS)] for _ in range(3)]


class MeshWalk:
    """What both sides know after each step: points, border edges, and the edges still to be crossed."""

    def __init__(self, bits: int) -> None:
        self.places = np.zeros((MOST_POINTS, 3))
        self.count = 0
        self.open = np.zeros(MOST_POINTS, np.int64)
        self.known: set[tuple[int, int]] = set()
        self.gates: deque[tuple[int, int, int]] = deque()
        self.models = WalkModels(bits)
        self.faces: list[tuple[int, int, int]] = []

    def add_point(self, place: FloatArray) -> int:
        """Add a point and return its number; raises `InputError` beyond MOST_POINTS."""
        if self.count == MOST_POINTS:
            raise InputError(f"a miniature has too many points, expected at most {MOST_POINTS}")
        self.places[self.count] = place
        self.count += 1
        return self.count - 1

    def add_face(self, a: int, b: int, c: int) -> None:
        """Add a face; each of its edges that it has alone so far becomes one to be crossed."""
        self.faces.append((a, b, c))
        for start, end, across in ((a, b, c), (b, c, a), (c, a, b)):
            self.known.add((start, end))
            if (end, start) in self.known:
                self.open[[start, end]] -= 1
            else:
                self.open[[start, end]] += 1
                self.gates.append((end, start, across))

    def next_gates(self) -> Iterator[tuple[int, int, int]]:
        """Yield directed edges that a further face may have, and the point on the other side."""
        while self.gates:
            a, b, across = self.gates.popleft()
            if (a, b) not in self.known:
                yield a, b, across

    def predicted(self, a: int, b: int, across: int) -> tuple[FloatArray, FloatArray]:
        """Return where a parallelogram would have the next point, and axes (3, 3): along, off, out."""
        start, end, other = self.places[a], self.places[b], self.places[across]
        along = _unit(end - start)
        out = _unit(_cross(end - start, start - other))
        return start + end - other, np.stack([along, _cross(out, along), out])

    def ranking(self, a: int, b: int, place: FloatArray) -> tuple[IntArray, int]:
        """Return the border points, nearest to `place` first, and the context."""
        self.open[[a, b]] += 1 << 30
        rows = np.flatnonzero((self.open[: self.count] > 0) & (self.open[: self.count] < 1 << 29))
        self.open[[a, b]] -= 1 << 30
        squared = ((self.places[rows] - place) ** 2).sum(axis=1)
        edge = self.places[a] - self.places[b]
        order = rows[np.argsort(squared, kind="stable")]
        nearest = float(squared.min()) if len(rows) else np.inf
        share = (nearest / max(float(edge @ edge), 1.0)) ** 0.5
        return order, int(np.searchsorted(NEAR, share))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a x b of two vectors (3,): numpy's own takes ten times as long for so few numbers."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _unit(vector: FloatArray) -> FloatArray:
    length = float(vector @ vector) ** 0.5
    return vector / length if length > 0.0 else np.zeros(3)

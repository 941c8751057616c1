"""The walk over a small mesh that both sides of its coding take: faces are crossed edge by edge.

Plain numbers, one edge at a time: arrays of three cost ten times as much. Only operations that IEEE 754 rounds
exactly (+, -, *, /, sqrt), in an order that is written out, so that both sides agree on every machine.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

from meshmark.errors import InputError

__all__ = ["Gate", "MeshWalk", "Point", "Prediction"]

Point = tuple[float, float, float]
Gate = tuple[int, int, int]
"""A directed edge that a further face may have, and the point on its other side."""

MOST_POINTS = 60_000
# Places, in steps, are nearer to the origin than this but in damaged bytes.
FARTHEST = 2.0**24


@dataclass(frozen=True, kw_only=True, slots=True)
class Prediction:
    """What a gate tells of the third corner of the face beyond it.

    place: where a parallelogram would have it; along, off, out: unit vectors along the edge, in the plane of the
    face before and out of it; length: of the edge.
    """

    place: Point
    along: Point
    off: Point
    out: Point
    length: float


class MeshWalk:
    """What both sides know after each step: points, faces, and the edges still to be crossed.

    faces_at: how many faces each point has.
    """

    def __init__(self) -> None:
        self.places: list[Point] = []
        self.faces: list[tuple[int, int, int]] = []
        self.faces_at: list[int] = []
        self._known: set[tuple[int, int]] = set()
        self._gates: deque[Gate] = deque()
        # The ends of the open gates from each point, and the starts of those to it, in the order they came.
        self._from: dict[int, dict[int, None]] = {}
        self._to: dict[int, dict[int, None]] = {}

    def add_point(self, place: Point) -> int:
        """Add a point and return its number; raises `InputError` beyond MOST_POINTS, and beyond FARTHEST."""
        if len(self.places) == MOST_POINTS:
            raise InputError(f"a miniature has too many points, expected at most {MOST_POINTS}")
        if max(place) > FARTHEST or min(place) < -FARTHEST:
            raise InputError(
                "the miniature has a point too far from the others, expected one that meshmark made"
            )
        self.places.append(place)
        self.faces_at.append(0)
        return len(self.places) - 1

    def add_face(self, a: int, b: int, c: int) -> None:
        """Add a face; each of its edges that it has alone so far becomes one to be crossed."""
        self.faces.append((a, b, c))
        known = self._known
        for start, end, across in ((a, b, c), (b, c, a), (c, a, b)):
            self.faces_at[start] += 1
            known.add((start, end))
            self._close(start, end)
            if (end, start) not in known:
                self._gates.append((end, start, across))
                self._from.setdefault(end, {})[start] = None
                self._to.setdefault(start, {})[end] = None

    def next_gates(self) -> Iterator[Gate]:
        """Yield the gates, first come first, each closed when it is yielded."""
        while self._gates:
            gate = self._gates.popleft()
            if gate[:2] not in self._known:
                self._close(gate[0], gate[1])
                yield gate

    def _close(self, start: int, end: int) -> None:
        ends = self._from.get(start)
        if ends is not None and end in ends:
            del ends[end], self._to[end][start]
            if not ends:
                del self._from[start]

    def gap(self, gate: Gate) -> int | None:
        """Return where the border goes on from the gate's end: the face beyond may close that gap."""
        ends = self._from.get(gate[1])
        return None if not ends else next((end for end in ends if end != gate[0]), None)

    def leading(self, gate: Gate) -> int | None:
        """Return from where the border comes to the gate's start."""
        starts = self._to.get(gate[0])
        return None if not starts else next((start for start in starts if start != gate[1]), None)

    def border(self, place: Point) -> list[int]:
        """Return the points of the border, nearest to `place` first."""
        x, y, z = place

        def order(point: int) -> tuple[float, int]:
            u, v, w = self.places[point]
            return (u - x) * (u - x) + (v - y) * (v - y) + (w - z) * (w - z), point

        return sorted(self._from, key=order)

    def predicted(self, gate: Gate) -> Prediction:
        """Return what a gate tells of the third corner of the face beyond it."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self.places[corner] for corner in gate)
        ex, ey, ez = bx - ax, by - ay, bz - az
        length = sqrt(ex * ex + ey * ey + ez * ez)
        ux, uy, uz = _unit(ex, ey, ez)
        sx, sy, sz = ax - cx, ay - cy, az - cz
        nx, ny, nz = _unit(ey * sz - ez * sy, ez * sx - ex * sz, ex * sy - ey * sx)
        return Prediction(
            place=(ax + bx - cx, ay + by - cy, az + bz - cz),
            along=(ux, uy, uz),
            off=(ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux),
            out=(nx, ny, nz),
            length=length,
        )


def _unit(x: float, y: float, z: float) -> Point:
    length = sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length) if length > 0.0 else (0.0, 0.0, 0.0)

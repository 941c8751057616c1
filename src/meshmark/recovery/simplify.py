"""Simplification to very few points: quadric edge collapse that keeps the surface a surface.

A library takes large models down to a few thousand points. From there edges collapse one by one, cheapest first
(M. Garland, P. Heckbert 1997, doi:10.1145/258734.258849), and only where the surface stays of the same kind (the
link condition) and no face turns over.
"""

from __future__ import annotations

import heapq

import numpy as np

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import area_vectors
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.coarse import coarse_surface

__all__ = ["Simplification", "simplify"]

Point = tuple[float, float, float]

# The library leaves this many points for each that is wanted, and at least AT_LEAST; more of a surface of many
# parts, of which it would empty the small ones. Those have fewer than CLOSED faces for each point; a closed surface
# has two.
FOR_EACH, FOR_EACH_OF_PARTS, AT_LEAST = 1.0, 4.0, 300
CLOSED = 1.8
# Pull of border edges, and of points towards where they are, against the pull of faces.
BORDER, STILL = 10.0, 1e-3
LEAST_COSINE = 0.2


def simplify(points: FloatArray, faces: IntArray, count: int) -> tuple[FloatArray, IntArray]:
    """Return points and faces of the surface with about `count` points, more where no edge can collapse.

    Faces with edges that more than two faces share stay as they are.
    """
    return Simplification(points, faces, count).to(count)


class Simplification:
    """A surface that gets simpler step by step."""

    def __init__(self, points: FloatArray, faces: IntArray, most: int) -> None:
        """Prepare for at most `most` points."""
        times = FOR_EACH if len(faces) >= CLOSED * len(points) else FOR_EACH_OF_PARTS
        first = max(int(times * most), AT_LEAST)
        # A closed surface has two faces for each point, a polygon soup may have fewer faces than the target.
        if len(points) > 1.2 * first and len(faces) > 2 * first:
            coarse = coarse_surface(points, faces, 2 * first)
            if len(coarse[1]):
                points, faces = coarse
        self._mesh = _Collapser(points, faces)

    def to(self, count: int) -> tuple[FloatArray, IntArray]:
        """Return points and faces with about `count` points, which must be fewer each time."""
        return self._mesh.run(count)


class _Collapser:
    """A mesh as sets, with the quadric (sum of squared distances to planes) of each point.

    One edge at a time is looked at, for which plain numbers are ten times as fast as arrays.
    """

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        self.points: list[Point] = [(x, y, z) for x, y, z in points.tolist()]
        self.faces: dict[int, tuple[int, int, int]] = {
            i: (int(a), int(b), int(c)) for i, (a, b, c) in enumerate(faces)
        }
        self.at: list[set[int]] = [set() for _ in points]
        for number, face in self.faces.items():
            for corner in face:
                self.at[corner].add(number)
        quadric = _quadrics(points, faces)
        self.quadric: list[list[float]] = quadric.tolist()
        self.version = [0] * len(points)
        self.alive = sum(1 for there in self.at if there)
        edges = unique_edges(faces)
        costs = _costs(points, quadric, edges)
        self.heap = [(cost, a, b, 0, 0) for cost, (a, b) in zip(costs.tolist(), edges.tolist(), strict=True)]
        heapq.heapify(self.heap)

    def ring(self, point: int) -> set[int]:
        """Return the neighbours of a point."""
        around: set[int] = set()
        for number in self.at[point]:
            around.update(self.faces[number])
        around.discard(point)
        return around

    def run(self, count: int) -> tuple[FloatArray, IntArray]:
        """Collapse until `count` points are left."""
        heap = self.heap
        while self.alive > count and heap:
            _, a, b, first, second = heapq.heappop(heap)
            if self.version[a] != first or self.version[b] != second or not self.at[a] or not self.at[b]:
                continue
            place = self._place(a, b)[1]
            if not self._allowed(a, b, place):
                continue
            self._collapse(a, b, place)
            self.alive -= 1
            for other in self.ring(a):
                heapq.heappush(heap, self._entry(min(a, other), max(a, other)))
        return self._result()

    def _entry(self, a: int, b: int) -> tuple[float, int, int, int, int]:
        return self._place(a, b)[0], a, b, self.version[a], self.version[b]

    def _place(self, a: int, b: int) -> tuple[float, Point]:
        """Return what the collapse costs, and where its point is: the least of the quadric, held to the middle."""
        one, other = self.quadric[a], self.quadric[b]
        xx, xy, xz = one[0] + other[0], one[1] + other[1], one[2] + other[2]
        yy, yz, zz = one[3] + other[3], one[4] + other[4], one[5] + other[5]
        x, y, z, constant = one[6] + other[6], one[7] + other[7], one[8] + other[8], one[9] + other[9]
        (ax, ay, az), (bx, by, bz) = self.points[a], self.points[b]
        middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
        square = (ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2
        hold = STILL * (xx + yy + zz) + 1e-30
        place = _solved(
            (xx + hold, xy, xz, yy + hold, yz, zz + hold),
            (x + hold * middle[0], y + hold * middle[1], z + hold * middle[2]),
        )
        u, v, w = place or middle
        if (u - middle[0]) ** 2 + (v - middle[1]) ** 2 + (w - middle[2]) ** 2 > square:
            u, v, w = middle
        cost = xx * u * u + yy * v * v + zz * w * w + 2.0 * (xy * u * v + xz * u * w + yz * v * w)
        cost += constant - 2.0 * (x * u + y * v + z * w)
        return max(cost, 0.0) + 1e-9 * square**2, (u, v, w)

    def _allowed(self, a: int, b: int, place: Point) -> bool:
        shared = self.at[a] & self.at[b]
        if not 1 <= len(shared) <= 2:
            return False
        opposite = {corner for number in shared for corner in self.faces[number]} - {a, b}
        if self.ring(a) & self.ring(b) != opposite:
            return False
        if len(self.at[a] | self.at[b]) <= 4:  # a tetrahedron stays
            return False
        if len(shared) == 2 and self._on_border(a) and self._on_border(b):
            return False
        return all(self._keeps_side(number, {a, b}, place) for number in (self.at[a] | self.at[b]) - shared)

    def _on_border(self, point: int) -> bool:
        return len(self.ring(point)) != len(self.at[point])

    def _keeps_side(self, number: int, ends: set[int], place: Point) -> bool:
        points, (a, b, c) = self.points, self.faces[number]
        one = _normal(points[a], points[b], points[c])
        other = _normal(
            place if a in ends else points[a],
            place if b in ends else points[b],
            place if c in ends else points[c],
        )
        sizes = _dot(one, one) * _dot(other, other)
        return _dot(one, other) > LEAST_COSINE * sizes**0.5 or not any(one)

    def _collapse(self, a: int, b: int, place: Point) -> None:
        for number in self.at[a] & self.at[b]:
            for corner in self.faces.pop(number):
                self.at[corner].discard(number)
        for number in self.at[b]:
            x, y, z = (a if corner == b else corner for corner in self.faces[number])
            self.faces[number] = (x, y, z)
            self.at[a].add(number)
        self.at[b] = set()
        self.points[a] = place
        self.quadric[a] = [one + other for one, other in zip(self.quadric[a], self.quadric[b], strict=True)]
        self.version[a] += 1

    def _result(self) -> tuple[FloatArray, IntArray]:
        faces = np.array(list(self.faces.values()), np.int64).reshape(-1, 3)
        used, corners = np.unique(faces, return_inverse=True)
        return np.array(self.points)[used].reshape(-1, 3), corners.reshape(-1, 3)


def _normal(a: Point, b: Point, c: Point) -> Point:
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _solved(matrix: tuple[float, float, float, float, float, float], right: Point) -> Point | None:
    """Return the solution for a symmetric matrix (xx, xy, xz, yy, yz, zz) by its adjugate, None for a flat one."""
    a, b, c, d, e, f = matrix
    one, two, three = d * f - e * e, c * e - b * f, b * e - c * d
    size = a * one + b * two + c * three
    if not size > 0.0:
        return None
    four, five, six = a * f - c * c, b * c - a * e, a * d - b * b
    x, y, z = right
    return (
        (one * x + two * y + three * z) / size,
        (two * x + four * y + five * z) / size,
        (three * x + five * y + six * z) / size,
    )


def _costs(points: FloatArray, quadric: FloatArray, edges: IntArray) -> FloatArray:
    """Return (e,): what the collapse of each edge (e, 2) costs, as `_Collapser._place` has it."""
    one, other = points[edges[:, 0]], points[edges[:, 1]]
    both, middle = quadric[edges[:, 0]] + quadric[edges[:, 1]], 0.5 * (one + other)
    square = ((one - other) ** 2).sum(axis=1)
    matrix = both[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    hold = STILL * np.trace(matrix, axis1=1, axis2=2) + 1e-30
    held = matrix + hold[:, None, None] * np.eye(3)
    solvable = np.linalg.det(held) > 0.0
    held[~solvable] = np.eye(3)
    place = np.linalg.solve(held, (both[:, 6:9] + hold[:, None] * middle)[:, :, None])[:, :, 0]
    far = ~solvable | (((place - middle) ** 2).sum(axis=1) > square)
    place[far] = middle[far]
    cost = np.einsum("ij,ijk,ik->i", place, matrix, place) - 2.0 * (both[:, 6:9] * place).sum(axis=1)
    return np.asarray(np.maximum(cost + both[:, 9], 0.0) + 1e-9 * square**2)


def _quadrics(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (p, 10): matrix (xx, xy, xz, yy, yz, zz), vector and constant; planes by area, and border walls."""
    vectors = area_vectors(points, faces)
    areas = np.maximum(np.sqrt((vectors**2).sum(axis=1)), 1e-300)
    planes, corners, weights = [vectors / areas[:, None]], [faces], [areas / 3.0]
    wall, ends, size = _walls(points, faces, planes[0])
    planes.append(wall)
    corners.append(np.concatenate([ends, ends[:, :1]], axis=1))
    weights.append(BORDER * size)
    quadric = np.zeros((len(points), 10))
    for normal, corner, weight in zip(planes, corners, weights, strict=True):
        height = np.einsum("ij,ij->i", normal, points[corner[:, 0]])
        x, y, z = normal.T
        rows = np.stack([x * x, x * y, x * z, y * y, y * z, z * z, *(height * normal.T), height**2], axis=1)
        for column in corner.T:
            np.add.at(quadric, column, weight[:, None] * rows)
    return quadric


def _walls(
    points: FloatArray, faces: IntArray, normals: FloatArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return normals of walls on the border edges, the edges (b, 2), and their squared lengths."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * len(points) + high
    _, place, times = np.unique(key, return_inverse=True, return_counts=True)
    border = np.flatnonzero(times[place] == 1)
    ends = np.stack([start[border], end[border]], axis=1)
    along = points[ends[:, 1]] - points[ends[:, 0]]
    wall = np.cross(along, normals[border // 3])
    length = np.maximum(np.sqrt((wall**2).sum(axis=1)), 1e-300)
    return wall / length[:, None], ends, (along**2).sum(axis=1)

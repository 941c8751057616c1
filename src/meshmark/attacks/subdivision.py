"""Subdivision: every face becomes four, or three, and the smooth schemes move the old points too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.attack import Attacked, Given
from meshmark.errors import InputError
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["loop", "midpoint", "sqrt3", "sqrt3_faces"]

MAX_FACES = 20_000_000

Step = Callable[[FloatArray, IntArray], tuple[FloatArray, IntArray]]


def midpoint(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Split each edge in the middle and each face into four, `strength` (1, 2, ...) times; the surface stays.

    All subdivisions work on welded points, so seams stay closed; the old points keep their numbers (`origin`), new
    ones follow. Raises `InputError` for a strength that is no whole number or makes over 20 million faces.
    """
    return _repeated(mesh, strength, _midpoint, 4)


def loop(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Subdivide by Loop's scheme (1987) `strength` (1, 2, ...) times.

    Borders follow the cubic spline (1/8, 3/4, 1/8); an edge with more than two faces counts as border, and a point
    where other than two border edges meet stays. Raises as `midpoint` does.
    """
    return _repeated(mesh, strength, _loop, 4)


def sqrt3(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Subdivide by Kobbelt's root-3 scheme (doi:10.1145/344779.344835) `strength` (1, 2, ...) times.

    Each face gets a point in its middle, and each inner edge is turned to join two of them. Border edges stay as
    they are, as do edges whose two faces are wound against each other. Raises as `midpoint` does.
    """
    return _repeated(mesh, strength, _sqrt3, 3)


def _repeated(mesh: Mesh, strength: float, step: Step, growth: int) -> Attacked:
    if strength != int(strength):
        raise InputError(f"strength {strength:g} is out of range, expected a whole number of levels")
    welded = weld(mesh)
    points, faces = welded.points, welded.faces
    if len(faces) * float(growth) ** min(strength, 100.0) > MAX_FACES:
        raise InputError(
            f"{strength:g} levels of subdivision make too many faces of {len(faces)}, expected at most {MAX_FACES}"
        )
    for _ in range(int(strength)):
        points, faces = step(points, faces)
    origin = np.full(len(points), -1)
    origin[: len(welded.points)] = welded.vertex_of_point
    return Attacked(mesh=Mesh(points, faces), origin=origin)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Edges:
    """The edges of a surface.

    ends: (e, 2), smaller first. of_face: (m, 3) the edge from each corner to the next.
    border: (e,) whether other than two faces have it. opposed: (e,) whether exactly two walk it in opposite ways.
    """

    ends: IntArray
    of_face: IntArray
    border: NDArray[np.bool_]
    opposed: NDArray[np.bool_]


def _edges(faces: IntArray, count: int) -> _Edges:
    ends = unique_edges(faces)
    start, end = faces, np.roll(faces, -1, axis=1)
    name = np.minimum(start, end) * count + np.maximum(start, end)
    of_face = np.searchsorted(ends[:, 0] * count + ends[:, 1], name)
    sides = np.bincount(of_face.ravel(), minlength=len(ends))
    forward = np.bincount(of_face[start < end], minlength=len(ends))
    return _Edges(ends=ends, of_face=of_face, border=sides != 2, opposed=(sides == 2) & (forward == 1))


def _in_four(points: FloatArray, faces: IntArray, edges: _Edges) -> IntArray:
    a, b, c = faces.T
    ab, bc, ca = edges.of_face.T + len(points)
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)


def _midpoint(points: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    edges = _edges(faces, len(points))
    middle = 0.5 * (points[edges.ends[:, 0]] + points[edges.ends[:, 1]])
    return np.concatenate([points, middle]), _in_four(points, faces, edges)


def _loop(points: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    edges = _edges(faces, len(points))
    one, other = edges.ends.T
    middle = 0.5 * (points[one] + points[other])
    opposite = np.zeros_like(middle)  # sum of the two points across each edge
    np.add.at(opposite, edges.of_face.ravel(), points[np.roll(faces, 1, axis=1)].reshape(-1, 3))
    inner = ~edges.border
    middle[inner] = 0.75 * middle[inner] + 0.125 * opposite[inner]

    old = points.copy()
    boundary = np.bincount(edges.ends[edges.border].ravel(), minlength=len(points))
    smooth, along = boundary == 0, boundary == 2
    valence, around = _ring(points, edges.ends)
    smooth &= valence > 0
    n = np.maximum(valence, 1)
    weight = 0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / n)) ** 2
    mean = around / n[:, None]
    old[smooth] += weight[smooth, None] * (mean - points)[smooth]
    _, beside = _ring(points, edges.ends[edges.border])
    old[along] = 0.75 * points[along] + 0.125 * beside[along]
    return np.concatenate([old, middle]), _in_four(points, faces, edges)


def sqrt3_faces(faces: IntArray, count: int) -> IntArray:
    """Return (3m, 3): the root-3 pattern; point `count + i` is the middle of face i of `faces` (m, 3)."""
    return _fans(faces, _edges(faces, count), count)


def _fans(faces: IntArray, edges: _Edges, count: int) -> IntArray:
    own = np.repeat(np.arange(len(faces)), 3)
    edge = edges.of_face.ravel()
    both = np.bincount(edge, weights=own, minlength=len(edges.ends)).astype(np.int64)
    across = both[edge] - own + count  # the middle of the face on the other side
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    return np.stack([start, np.where(edges.opposed[edge], across, end), own + count], axis=1)


def _sqrt3(points: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    edges = _edges(faces, len(points))
    valence, around = _ring(points, edges.ends)
    fixed = valence == 0
    fixed[edges.ends[~edges.opposed].ravel()] = True
    n = np.maximum(valence, 1)
    weight = np.where(fixed, 0.0, (4.0 - 2.0 * np.cos(2.0 * np.pi / n)) / 9.0)
    old = np.where(fixed[:, None], points, points + weight[:, None] * (around / n[:, None] - points))
    return np.concatenate([old, points[faces].mean(axis=1)]), _fans(faces, edges, len(points))


def _ring(points: FloatArray, ends: IntArray) -> tuple[IntArray, FloatArray]:
    """Return for each point how many of these edges it has, and the sum of the points at their other ends."""
    one, other = np.concatenate([ends, ends[:, ::-1]]).T
    valence = np.bincount(one, minlength=len(points))
    sums = [np.bincount(one, weights=axis[other], minlength=len(points)) for axis in points.T]
    return valence, np.stack(sums, axis=1)

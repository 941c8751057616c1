"""Neighbourhoods of vertices on the surface: everything that outward edges reach within a sphere.

From the centre on, an edge is followed where it leads away from the centre, and cut where it leaves the sphere.
Distances to the centre grow along such paths, so one growth to the largest radius holds those to all smaller ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from meshmark.arrays import sorted_distinct
from meshmark.geometry.adjacency import unique_edges
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Growth", "HalfEdges", "grow_all", "half_edges"]

EDGES_AT_ONCE = 1 << 17  # a block's arrays stay near the processor; bounds memory


@dataclass(frozen=True, eq=False, kw_only=True)
class HalfEdges:
    """The edges of a mesh in both directions, sorted by where they start.

    begin: (p + 1,) the half-edges that start at point i are begin[i] to begin[i + 1]; start, end: (h,) points;
    vectors (h, 3) from start to end; squares (h,) their squared lengths; edge: (h,) row of `edges` (e, 2), which
    holds each edge once.
    """

    begin: IntArray
    start: IntArray
    end: IntArray
    vectors: FloatArray
    squares: FloatArray
    edge: IntArray
    edges: IntArray


def half_edges(points: FloatArray, faces: IntArray) -> HalfEdges:
    """Return the half-edges of a mesh; points without faces have none."""
    edges = unique_edges(faces)
    start = np.concatenate([edges[:, 0], edges[:, 1]])
    order = np.argsort(start, kind="stable")
    start, end = start[order], np.concatenate([edges[:, 1], edges[:, 0]])[order]
    vectors = points.take(end, axis=0) - points.take(start, axis=0)
    squares = np.einsum("ij,ij->i", vectors, vectors)
    begin = np.searchsorted(start, np.arange(len(points) + 1))
    return HalfEdges(
        begin=begin,
        start=start,
        end=end,
        vectors=vectors,
        squares=squares,
        edge=order % max(len(edges), 1),
        edges=edges,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Growth:
    """The neighbourhoods of the points `centres` (c,), as flat lists; `owner` is a row of `centres`.

    Points reached: owner, point, squared (distance to the centre), the centre itself included.
    Edges followed: edge_owner, half_edge, along (its vector times the start's offset from the centre), near and
    far (squared distances of start and end). Edges that leave the sphere are included.
    """

    centres: IntArray
    owner: IntArray
    point: IntArray
    squared: FloatArray
    edge_owner: IntArray
    half_edge: IntArray
    along: FloatArray
    near: FloatArray
    far: FloatArray

    def crossing(self, graph: HalfEdges, radius: float, edges: IntArray) -> FloatArray:
        """Return at what share of their length the edges in rows `edges` leave the sphere, 0 to 1."""
        a, b = graph.squares.take(self.half_edge.take(edges)), self.along.take(edges)
        root = np.sqrt(np.maximum(b * b + a * (radius * radius - self.near.take(edges)), 0.0))
        share: FloatArray = np.clip((root - b) / a, 0.0, 1.0)
        return share


def grow_all(points: FloatArray, graph: HalfEdges, centres: IntArray, radius: float) -> Iterator[Growth]:
    """Yield the neighbourhoods of `centres` within `radius`, a block of centres at a time."""
    first, count = 0, 256
    while first < len(centres):
        growth = _grow(points, graph, centres[first : first + count], radius)
        yield growth
        first += count
        per_centre = max(len(growth.half_edge), 1) / len(growth.centres)
        count = max(int(EDGES_AT_ONCE / per_centre), 1)


def _grow(points: FloatArray, graph: HalfEdges, centres: IntArray, radius: float) -> Growth:
    owner, point = np.arange(len(centres)), centres
    offset = np.zeros((3, len(centres)))
    squared = np.zeros(len(centres))
    reached, followed = [(owner, point, squared)], []
    seen = owner * len(points) + point
    while len(point):
        edge, source = _edges_from(graph, point)
        along = _dot(graph.vectors.take(edge, axis=0).T, offset.take(source, axis=1))
        outward = np.flatnonzero((along > 0.0) | (squared.take(source) == 0.0))
        edge, source, along = edge.take(outward), source.take(outward), along.take(outward)
        near = squared.take(source)
        far = near + 2.0 * along + graph.squares.take(edge)
        owner = owner.take(source)
        followed.append((owner, edge, along, near, far))
        inside = np.flatnonzero(far <= radius * radius)
        key = owner.take(inside) * len(points) + graph.end.take(edge.take(inside))
        key = sorted_distinct(key)
        place = np.searchsorted(seen, key)
        place[place == len(seen)] = 0
        new = np.flatnonzero(seen.take(place) != key)
        seen = np.sort(np.concatenate([seen, key.take(new)]))
        owner, point = np.divmod(key.take(new), len(points))
        offset = (points.take(point, axis=0) - points.take(centres.take(owner), axis=0)).T
        squared = _dot(offset, offset)
        reached.append((owner, point, squared))
    owners, points_, squares = (np.concatenate(parts) for parts in zip(*reached, strict=True))
    edge_owners, edges, alongs, nears, fars = (np.concatenate(parts) for parts in zip(*followed, strict=True))
    return Growth(
        centres=centres,
        owner=owners,
        point=points_,
        squared=squares,
        edge_owner=edge_owners,
        half_edge=edges,
        along=alongs,
        near=nears,
        far=fars,
    )


def _edges_from(graph: HalfEdges, point: IntArray) -> tuple[IntArray, IntArray]:
    """Return all half-edges that start at the points, and the row of `point` of each."""
    sizes = graph.begin.take(point + 1) - graph.begin.take(point)
    source = np.repeat(np.arange(len(point)), sizes)
    skipped = graph.begin.take(point) - (np.cumsum(sizes) - sizes)
    return np.arange(len(source)) + skipped.take(source), source


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    out: FloatArray = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return out

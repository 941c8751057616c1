"""The exact closest point of a triangle surface, for many query points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.arrays import members
from meshmark.errors import InputError
from meshmark.geometry.blocks import blocks
from meshmark.geometry.box_tree import BRANCHES, ROUNDING, BoxLevel, box_levels, level_bounds
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.point_triangle import Triangles
from meshmark.geometry.shared_places import SharedPlaces
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Nearest", "SurfaceIndex"]

QUERIES_AT_ONCE = 1 << 15
# Pairs of query and box that are looked at together: bounds memory where everything is equally near.
PAIRS_AT_ONCE = 1 << 18
# Queries farther away than this many extents are handled in double precision.
LARGEST_SINGLE = 1e6
# A face is tried for its distance at every third level: more often costs more than the pruning wins (measured).
GUESS_EVERY = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Nearest:
    """The closest point on the surface to each of n queries.

    distances: (n,); faces: (n,) the first face that holds the point; weights: (n, 3) barycentric coordinates in
    that face, none negative; points: (n, 3).
    """

    distances: FloatArray
    faces: IntArray
    weights: FloatArray
    points: FloatArray


class SurfaceIndex:
    """A surface prepared for closest-point queries: exact, and each face that can matter is tried.

    points: (p, 3); faces: (m, 3), at least one; faces without area count as the line or point that they are.
    Raises `InputError` for a surface without faces.
    """

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        if not len(faces):
            raise InputError("the surface has no faces, expected at least one")
        self._points, self._faces = points, faces
        used = points[faces.ravel()]
        low, high = used.min(axis=0), used.max(axis=0)
        self._centre = 0.5 * low + 0.5 * high
        # A power of two, so that scaling rounds nothing; squares then neither overflow nor vanish.
        self._unit = 2.0 ** np.floor(np.log2(max(float((high - low).max()), np.finfo(float).tiny)))
        self._triangles = Triangles.of((points - self._centre) / self._unit, faces)
        self._order, self._levels = box_levels(self._triangles)
        middles = self._triangles.corner + (self._triangles.first + self._triangles.second) / 3.0
        self._middles = kd_tree(middles)
        self._shared = SharedPlaces(faces)

    def nearest(self, queries: FloatArray) -> Nearest:
        """Return the closest point to each query, shape (n, 3)."""
        count = len(queries)
        distances, faces, shares = np.empty(count), np.empty(count, np.int64), np.empty((count, 2))
        for part in blocks(count, QUERIES_AT_ONCE):
            search = _Search(self._triangles, (queries[part] - self._centre) / self._unit)
            search.try_faces(
                np.arange(len(search.queries)), np.asarray(self._middles.query(search.queries)[1], np.int64)
            )
            search.descend(self._order, self._levels)
            distances[part], faces[part], shares[part] = search.distances, search.faces, search.shares
        distances *= self._unit
        weights = np.column_stack([np.maximum(1.0 - shares.sum(axis=1), 0.0), shares])
        corners = self._faces[faces]
        points = sum(weights[:, i, None] * self._points[corners[:, i]] for i in range(3))
        self._shared.use_first_face(faces, weights)
        return Nearest(
            distances=distances, faces=faces, weights=weights, points=np.asarray(points).reshape(-1, 3)
        )


class _Search:
    """The closest point found so far for each query of a block."""

    def __init__(self, triangles: Triangles, queries: FloatArray) -> None:
        self.triangles, self.queries = triangles, queries
        self.distances = np.full(len(queries), np.inf)
        self.faces = np.zeros(len(queries), np.int64)
        self.shares = np.zeros((len(queries), 2))
        size = np.abs(queries).max(axis=1, initial=1.0)
        self.slack = ROUNDING * size
        narrow = size.max(initial=1.0) < LARGEST_SINGLE
        self.columns = np.ascontiguousarray(queries.T, np.float32 if narrow else np.float64)

    def descend(self, order: IntArray, levels: list[BoxLevel]) -> None:
        """Follow all boxes that start closer than the best point, depth first in bundles of pairs."""
        bundles = [(0, np.arange(len(self.queries)), np.zeros(len(self.queries), np.int64))]
        ends = level_bounds(len(order), len(levels) - 1)
        while bundles:
            level, rows, boxes = bundles.pop()
            guess = level % GUESS_EVERY == GUESS_EVERY - 1
            rows, boxes = self._near_boxes(levels[level], rows, boxes, guess)
            if level + 1 == len(levels):
                starts = ends[boxes]
                pair, place = members(ends[boxes + 1] - starts)
                self.try_faces(rows[pair], order[starts[pair] + place])
                continue
            rows = np.repeat(rows, BRANCHES)
            boxes = (BRANCHES * boxes[:, None] + np.arange(BRANCHES)).ravel()
            bundles += [(level + 1, rows[part], boxes[part]) for part in blocks(len(rows), PAIRS_AT_ONCE)]

    def _near_boxes(
        self, level: BoxLevel, rows: IntArray, boxes: IntArray, guess: bool
    ) -> tuple[IntArray, IntArray]:
        """Return the pairs that may hold a closer point; a guess tries the largest face in the nearest box."""
        bounds = level.lower_bounds(self.columns, rows, boxes)
        near = np.flatnonzero(bounds < self.reach(rows))
        rows, boxes, bounds = rows[near], boxes[near], bounds[near]
        if not guess:
            return rows, boxes
        best = _first_smallest(rows, bounds)
        self.try_faces(rows[best], level.large[boxes[best]])
        near = np.flatnonzero(bounds < self.reach(rows))
        return rows[near], boxes[near]

    def reach(self, rows: IntArray) -> FloatArray:
        """Return how near a box must seem for these queries (n,) to hold a closer point."""
        out: FloatArray = self.distances.take(rows)
        out += self.slack.take(rows)
        return out

    def try_faces(self, rows: IntArray, faces: IntArray) -> None:
        """Keep what is closer; equal rows stand together."""
        distances, shares = self.triangles.closest(self.queries.take(rows, axis=0), faces)
        best = _first_smallest(rows, distances)
        best = best[distances[best] < self.distances[rows[best]]]
        self.distances[rows[best]] = distances[best]
        self.faces[rows[best]] = faces[best]
        self.shares[rows[best]] = shares[best]


def _first_smallest(rows: IntArray, values: FloatArray) -> IntArray:
    """Return, for each run of equal rows, the place of its smallest value."""
    if not len(rows):
        return np.zeros(0, np.int64)
    starts = np.flatnonzero(np.diff(rows, prepend=-1))
    smallest = np.repeat(np.minimum.reduceat(values, starts), np.diff(starts, append=len(rows)))
    places = np.flatnonzero(values == smallest)
    return places[np.searchsorted(places, starts)]

"""The connectivity of a surface, without its positions: edges, vertex graph and used points, each computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.geometry.adjacency import joined, unique_edges
from meshmark.geometry.extent import used_points
from meshmark.geometry.scale_space import walk_of
from meshmark.mesh import IntArray

__all__ = ["Connectivity"]

# What does not depend on how the corners of the faces go round.
SHARED = frozenset({"used", "edges", "graph", "walk"})


@dataclass(frozen=True, eq=False, kw_only=True)
class Connectivity:
    """How points are joined by faces; equal to itself only, so that it can be the key of a cache.

    count: number of points. faces: (m, 3) int64 indices of points.
    """

    count: int
    faces: IntArray

    def turned_over(self) -> Connectivity:
        """Return that of the faces with their corners the other way round; all else is shared."""
        result = Connectivity(count=self.count, faces=self.faces[:, ::-1])
        result.__dict__.update((name, self.__dict__[name]) for name in SHARED & self.__dict__.keys())
        return result

    @cached_property
    def used(self) -> NDArray[np.bool_]:
        """(count,) which points faces use."""
        return used_points(self.faces, self.count)

    @cached_property
    def edges(self) -> IntArray:
        """(e, 2) each undirected edge once, smaller index first, sorted."""
        start, end = np.repeat(np.arange(self.count), np.diff(self.graph.indptr)), self.graph.indices
        upper = start < end
        return np.stack([start[upper], end[upper]], axis=1)

    @cached_property
    def graph(self) -> csr_array:
        """(count, count) symmetric sparse int8 matrix with 1 at both places of each edge."""
        return joined(unique_edges(self.faces), self.count)

    @cached_property
    def walk(self) -> csr_array:
        """(count, count) uniform random walk (`walk_of`); a point without an edge stays where it is."""
        return walk_of(self.graph)

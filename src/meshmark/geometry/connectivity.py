"""The connectivity of a surface, without its positions: edges, vertex graph and used points, each computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.extent import used_points
from meshmark.mesh import IntArray

__all__ = ["Connectivity"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Connectivity:
    """How points are joined by faces; equal to itself only, so that it can be the key of a cache.

    count: number of points. faces: (m, 3) int64 indices of points.
    """

    count: int
    faces: IntArray

    @cached_property
    def used(self) -> NDArray[np.bool_]:
        """(count,) which points faces use."""
        return used_points(self.faces, self.count)

    @cached_property
    def edges(self) -> IntArray:
        """(e, 2) each undirected edge once, smaller index first, sorted."""
        return unique_edges(self.faces)

    @cached_property
    def graph(self) -> csr_array:
        """(count, count) symmetric sparse matrix with 1.0 at both places of each edge."""
        return adjacency(self.edges, self.count)

"""What was signed off as a whole: how many points and how much surface there were, to tell what is missing.

Marks tell what was changed where they are. A part of its own that is gone leaves no trace among the others, and one
that was added, of rings too fine for marks, shows none: but then the numbers do not agree.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import face_areas
from meshmark.geometry.weld import Welded

__all__ = ["SIZE", "Whole", "unmarked_parts", "used_points", "whole_of"]

_FORM = struct.Struct("<If")
SIZE = _FORM.size
"""Bytes of a packed `Whole`."""
# Points that are nearer to each other than so many errors of a coordinate may become one.
_APART = 20.0


@dataclass(frozen=True)
class Whole:
    """points: that faces use, 0 where they are not counted; area: in squares of half the diagonal, 0: unknown."""

    points: int = 0
    area: float = 0.0

    def packed(self) -> bytes:
        """Return `SIZE` bytes."""
        return _FORM.pack(self.points, self.area)

    @staticmethod
    def read(packed: bytes) -> Whole:
        """Undo `packed`."""
        return Whole(*_FORM.unpack(packed))


def whole_of(surface: Welded, precision: float) -> Whole:
    """Return the numbers of a surface; points are not counted where rounding may make two of them one."""
    used = used_points(surface)
    edges = unique_edges(surface.faces)
    steps = surface.points[edges[:, 0]] - surface.points[edges[:, 1]]
    apart = bool((np.einsum("ij,ij->i", steps, steps) > (_APART * precision) ** 2).all())
    half = 0.5 * float(np.linalg.norm(np.ptp(surface.points[used], axis=0)))
    area = float(face_areas(surface.points, surface.faces).sum())
    return Whole(int(used.sum()) if apart else 0, area / half**2)


def used_points(surface: Welded) -> NDArray[np.bool_]:
    """Return (p,): the points that faces use."""
    used = np.zeros(len(surface.points), bool)
    used[surface.faces] = True
    return used


def unmarked_parts(surface: Welded, verified: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): the points of connected parts of which no point is `verified` (p,)."""
    graph = adjacency(unique_edges(surface.faces), len(surface.points))
    part = connected_components(graph, directed=False)[1]
    marked = np.zeros(int(part.max(initial=-1)) + 1, bool)
    marked[part[verified]] = True
    return np.asarray(~marked[part] & used_points(surface))

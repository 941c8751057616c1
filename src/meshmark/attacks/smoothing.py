"""Laplacian and Taubin smoothing with equal weights over the 1-ring.

docs/design.md, section 10; G. Taubin, A signal processing approach to fair surface design (SIGGRAPH 1995),
doi:10.1145/218380.218473.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import repeat

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.moved_vertices import moved_points
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.scale_space import random_walk
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh

__all__ = ["smoothing", "smoothing_half", "taubin"]

LAMBDA, LAMBDA_HALF = 0.1, 0.5
TAUBIN = (0.5, -0.53)


def smoothing(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Move every point by 0.1 of the way to the mean of its 1-ring, all at once; strength counts the passes."""
    return _smoothed(mesh, repeat(LAMBDA, int(strength)))


def smoothing_half(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Move every point half of the way to the mean of its 1-ring, all at once; strength counts the passes."""
    return _smoothed(mesh, repeat(LAMBDA_HALF, int(strength)))


def taubin(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Smooth by 0.5, then inflate by 0.53; strength counts these pairs."""
    return _smoothed(mesh, TAUBIN * int(strength))


def _smoothed(mesh: Mesh, shares: Iterable[float]) -> Attacked:
    """Move by each of `shares` in turn. Borders move like all else; points without an edge stay."""
    welded = weld(mesh)
    points = welded.points
    walk = random_walk(points, unique_edges(welded.faces))
    for share in shares:
        points = points + share * (walk @ points - points)
    return moved_points(mesh, welded, points)

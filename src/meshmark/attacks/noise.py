"""Noise on the coordinates, uniform or normal (docs/design.md, section 10)."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.moved_vertices import mean_radius, moved_points
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh

__all__ = ["gaussian", "noise"]


def noise(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Move every coordinate by a number uniform in +-A r; strength is A, r the mean vertex-centroid distance."""
    welded, reach = weld(mesh), strength * mean_radius(mesh)
    return moved_points(mesh, welded, welded.points + rng.uniform(-reach, reach, welded.points.shape))


def gaussian(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Move every coordinate by a normal number of deviation A r; strength is A, r as for `noise`."""
    welded, sigma = weld(mesh), strength * mean_radius(mesh)
    return moved_points(mesh, welded, welded.points + rng.normal(0.0, sigma, welded.points.shape))

"""Moving the points of a mesh: coincident vertices stay together, so that no seam tears open."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, Mesh

__all__ = ["centroid", "mean_radius", "moved", "moved_points"]


def moved(mesh: Mesh, vertices: FloatArray) -> Attacked:
    """Return the mesh with its vertices at other places, (n, 3): same faces, same file, same numbers."""
    return Attacked(mesh=mesh.with_vertices(vertices), origin=np.arange(len(mesh.vertices)))


def moved_points(mesh: Mesh, welded: Surface, points: FloatArray) -> Attacked:
    """Return the mesh with the points of its weld at other places, (p, 3)."""
    return moved(mesh, points[welded.point_of_vertex])


def centroid(mesh: Mesh) -> FloatArray:
    """Return (3,): the mean of the vertices, as the benchmark defines it."""
    middle: FloatArray = mesh.vertices.mean(axis=0)
    return middle


def mean_radius(mesh: Mesh) -> float:
    """Return r, the mean distance of the vertices from their centroid (docs/design.md, section 10)."""
    return float(np.linalg.norm(mesh.vertices - centroid(mesh), axis=1).mean())

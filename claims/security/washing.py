"""How little displacement takes an id away, of a direction that an attacker chose: bisection over its size."""

from __future__ import annotations

import numpy as np

from claims.security.options import KEY
from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.extraction import extract

__all__ = ["bumps_at", "has_id", "moved_along", "random_field", "size_needed"]

# Waves of a random field, and their length over 2 pi, in spacings: bumps about as wide as those of a mark.
WAVES, WAVE = 160, 0.28
# Radius of one bump, in spacings.
RADIUS = 0.5


def random_field(mesh: Mesh, spacing: float, rng: np.random.Generator) -> FloatArray:
    """Return a smooth field (p,) with RMS 1 over the points, as wide as the bumps of a mark; keyless."""
    surface = surface_of(mesh)
    places = surface.frame.to_canonical(surface.points) / (WAVE * spacing)
    field = np.zeros(len(places))
    for _ in range(WAVES):
        field += np.cos(places @ rng.normal(size=3) + rng.uniform(0.0, 2.0 * np.pi))
    return np.asarray(field / np.sqrt(np.mean(field**2)))


def bumps_at(mesh: Mesh, centres: FloatArray, spacing: float, rng: np.random.Generator) -> FloatArray:
    """Return a field (p,) with RMS 1: a bump up or down around each centre (k, 3), canonical, that is near."""
    surface = surface_of(mesh)
    places = surface.frame.to_canonical(surface.points)
    field = np.zeros(len(places))
    for centre in centres:
        near = 1.0 - ((places - centre) ** 2).sum(axis=1) / (RADIUS * spacing) ** 2
        field += rng.choice([-1.0, 1.0]) * np.maximum(near, 0.0) ** 3
    return np.asarray(field / max(np.sqrt(np.mean(field**2)), np.finfo(float).tiny))


def moved_along(mesh: Mesh, field: FloatArray, size: float) -> Mesh:
    """Return the mesh with its points moved along their normals by a field (p,), times `size` of the diagonal."""
    surface = surface_of(mesh)
    _, normals = vertex_areas_and_normals(surface.points, surface.faces)
    points = surface.points + (size * surface.diagonal) * field[:, None] * normals
    return mesh.with_vertices(points[surface.point_of_vertex])


def has_id(mesh: Mesh, id: int) -> bool:
    """Return whether the id is read by the key alone: as it stands, else by the whole search."""
    return any(id in extract(mesh, KEY, search=search).ids for search in ("plain", "quick"))


def size_needed(mesh: Mesh, id: int, field: FloatArray, largest: float, halvings: int = 4) -> float:
    """Return the size, over the diagonal, at which the id is gone; `largest` where it is there even then."""
    low, high = 0.0, largest
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if has_id(moved_along(mesh, field, middle), id) else (low, middle)
    return high

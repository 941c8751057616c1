"""How much of a surface shows its marks."""

from __future__ import annotations

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh

__all__ = ["seen_share"]


def seen_share(original: Mesh, marked: Mesh) -> float:
    """Return the share of the surface, 0 to 1, where the marks of a mesh are visible (`geometry.visibility`)."""
    surface = surface_of(original)
    return surface.visible_change.of(marked.vertices[surface.vertex_of_point]).share

"""How far a mark moves the vertices of a model."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log10

import numpy as np

from meshmark.geometry.extent import diagonal, used_points
from meshmark.mesh import Mesh

__all__ = ["VertexDisplacement", "diagonal_of", "displacement_rms", "vertex_displacement"]


@dataclass(frozen=True, kw_only=True)
class VertexDisplacement:
    """Displacement of a model's vertices, in scene units.

    rms: over the vertices that faces use. largest: of any vertex. diagonal: of the box around the vertices that
    faces use, before they were moved.
    """

    rms: float
    largest: float
    diagonal: float

    @property
    def rms_over_diagonal(self) -> float:
        """Return the RMS displacement over the diagonal."""
        return self.rms / self.diagonal

    @property
    def max_over_diagonal(self) -> float:
        """Return the largest displacement over the diagonal."""
        return self.largest / self.diagonal

    @property
    def psnr_db(self) -> float:
        """Return 20 log10(diagonal / RMS), infinite where nothing moved."""
        return 20.0 * log10(self.diagonal / self.rms) if self.rms > 0.0 else inf


def vertex_displacement(mesh: Mesh, moved: Mesh) -> VertexDisplacement:
    """Return how far the vertices of a mesh were moved.

    Parameters
    ----------
    mesh, moved : Mesh
        With the same vertices, before and after.

    Returns
    -------
    VertexDisplacement
    """
    return VertexDisplacement(
        rms=displacement_rms(mesh, moved),
        largest=float(np.linalg.norm(moved.vertices - mesh.vertices, axis=1).max()),
        diagonal=diagonal_of(mesh),
    )


def diagonal_of(mesh: Mesh) -> float:
    """Return the diagonal of the box around the vertices that faces use, in scene units."""
    return diagonal(mesh.vertices, mesh.faces)


def displacement_rms(mesh: Mesh, other: Mesh) -> float:
    """Return the RMS distance, in scene units, of vertices that faces use from their places in `other`."""
    moved = (other.vertices - mesh.vertices)[used_points(mesh.faces, len(mesh.vertices))]
    return float(np.sqrt(np.einsum("ij,ij->", moved, moved) / len(moved)))

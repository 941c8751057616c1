"""How far vertices moved, vertex by vertex, as a share of the model's size (docs/design.md, section 11)."""

from __future__ import annotations

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import FloatArray, Mesh

__all__ = ["diagonal", "displacements", "max_over_diagonal", "rms_over_diagonal"]


def displacements(a: Mesh, b: Mesh) -> FloatArray:
    """Return (n,): the distance between each vertex of `a` and the vertex of `b` with the same number.

    Raises `InputError` when the vertex counts differ.
    """
    if len(a.vertices) != len(b.vertices):
        raise InputError(
            f"the models have {len(a.vertices)} and {len(b.vertices)} vertices, "
            "expected equal counts for a comparison vertex by vertex"
        )
    # hypot of three does not overflow or underflow where squaring would
    x, y, z = (b.vertices - a.vertices).T
    lengths: FloatArray = np.hypot(np.hypot(x, y), z)
    return lengths


def diagonal(mesh: Mesh) -> float:
    """Return the length of the bounding box's diagonal; raises `InputError` for a model without extent."""
    if not len(mesh.vertices):
        raise InputError("a model has no vertices, expected at least one")
    extent = np.ptp(mesh.vertices, axis=0)
    length = float(np.hypot(np.hypot(extent[0], extent[1]), extent[2]))
    if length == 0.0:
        raise InputError("all vertices of the model are in one place, expected a model with an extent")
    return length


def rms_over_diagonal(a: Mesh, b: Mesh) -> float:
    """Return the RMS vertex displacement over the diagonal of `a`, 0 upwards (eq. 18 over the diagonal)."""
    size = diagonal(a)
    return float(np.sqrt(np.mean(np.square(displacements(a, b) / size))))


def max_over_diagonal(a: Mesh, b: Mesh) -> float:
    """Return the largest vertex displacement over the diagonal of `a`, 0 upwards."""
    size = diagonal(a)
    return float(displacements(a, b).max()) / size

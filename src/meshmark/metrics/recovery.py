"""How close a recovered model came to the original (docs/design.md, section 11)."""

from __future__ import annotations

from meshmark.mesh import Mesh
from meshmark.metrics.surface_distance import symmetric_rms_over_diagonal

__all__ = ["recovery_rms_over_diagonal"]


def recovery_rms_over_diagonal(original: Mesh, recovered: Mesh) -> float:
    """Return the symmetric RMS surface distance over the original's diagonal, 0 upwards.

    Surfaces are compared, not vertices: filled-in parts have triangles of their own. A part that stayed missing
    counts through the direction from the original. Raises `InputError` where a model has no surface.
    """
    return symmetric_rms_over_diagonal(original, recovered)

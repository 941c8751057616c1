"""The normals stored with STL facets: derived data, kept right where they were right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["facet_normals", "stale_facets"]

# A stored normal this close to the facet's is taken as computed from it: some exporters work in float32
# or print five digits.
_TOLERANCE = 1e-3


def facet_normals(corners: FloatArray) -> FloatArray:
    """Return (m, 3) unit normals of (m, 3, 3) facets; zero where a facet has no area."""
    # Scaled first, so that tiny and huge facets neither vanish nor overflow in the product.
    edges = corners[:, 1:] / 2 - corners[:, :1] / 2
    size = np.abs(edges).max(axis=(1, 2), keepdims=True)
    edges = np.divide(edges, size, out=np.zeros_like(edges), where=size > 0)
    normals = np.cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=length > 0))


def stale_facets(stored: FloatArray, before: FloatArray, after: FloatArray) -> NDArray[np.bool_]:
    """Return (m,) which stored normals have to follow: right for (m, 3, 3) `before`, corners moved since.

    A zero normal, a wrong one, and one of a facet without area stay as they are.
    """
    moved = (before != after).any(axis=(1, 2))
    stale = np.zeros(len(stored), dtype=bool)
    right = facet_normals(before[moved])
    close = np.isfinite(stored[moved]) & (np.abs(np.nan_to_num(stored[moved]) - right) <= _TOLERANCE)
    stale[moved] = close.all(axis=1) & right.any(axis=1) & facet_normals(after[moved]).any(axis=1)
    return stale

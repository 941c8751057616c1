"""The k-d tree over points, of `scipy.spatial`, which takes long to import and is imported with the first tree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["kd_tree"]


def kd_tree(points: FloatArray, leafsize: int = 16) -> cKDTree:
    """Return the k-d tree of points (n, d); at most `leafsize` of them are searched one by one."""
    from scipy.spatial import cKDTree

    return cKDTree(points, leafsize=leafsize)

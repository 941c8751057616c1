"""Simplification by quadric edge collapse: what model viewers, scanners' software and web pipelines do first."""

from __future__ import annotations

import fast_simplification
import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.errors import InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["decimated", "simplification"]

# The library sweeps over the faces and collapses what costs less than a threshold of 1e-9 (sweep + 3)^7, a squared
# length. On a model of this size the first thresholds are far below any cost, so the cheapest edges go first
# everywhere; a size of 1 would strip the faces that come first in the file. The smaller sizes are for what is left.
SIZES = (2000.0, 20.0, 0.2)


def simplification(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Remove the share `strength` (0 to 1) of the faces by quadric edge collapse (Garland and Heckbert 1997).

    Works on welded points, so texture seams stay closed; points that no face uses go. `origin` is the vertex that a
    chain of collapses left over, which has moved to the optimal place. Where borders or folds leave no edge to
    collapse more faces stay than asked for.

    Raises `InputError` for a strength of 1 or more, and a mesh without faces.
    """
    if strength >= 1.0:
        raise InputError(f"strength {strength:g} is out of range, expected a share of faces below 1")
    welded = weld(mesh)
    used, corners = np.unique(welded.faces, return_inverse=True)
    if not len(used):
        raise InputError(
            "the model has no faces to simplify, expected at least one with three different points"
        )
    faces = corners.reshape(-1, 3)
    target = max(round((1.0 - strength) * len(faces)), 4)
    points, faces, kept = decimated(welded.points[used], faces, target)
    return Attacked(mesh=Mesh(points, faces), origin=welded.vertex_of_point[used[kept]])


def decimated(points: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points (p', 3) and about `target` faces (m', 3) of a surface, and which of its points each one was,
    (p',).

    All `points` (p, 3) belong to one of the `faces` (m, 3).
    """
    kept = np.arange(len(points))
    for size in SIZES:
        if len(faces) <= target:
            break
        points, faces, left = _collapse(points, faces, target, size)
        kept = kept[left]
    return points, faces, kept


def _collapse(
    points: FloatArray, faces: IntArray, target: int, size: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points, faces and which point each one was, collapsed at this size of the model."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, scale = 0.5 * (low + high), float(np.linalg.norm(high - low)) / size
    moved, left_faces, collapses = fast_simplification.simplify(
        (points - middle) / scale, faces.astype(np.int32), target_count=target, return_collapses=True
    )
    root = np.arange(len(points))
    root[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(root, root[root]):
        root = root[root]
    a, b, c = (ends := root[faces]).T
    left = np.unique(ends[(a != b) & (b != c) & (c != a)])
    return moved * scale + middle, left_faces.astype(np.int64), left

"""One face for places that several share: a point on an edge or corner belongs to the first face there."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["SharedPlaces"]

# Barycentric coordinates below this are 0 but for rounding.
ZERO = 1e-12


class SharedPlaces:
    """The first face at each point and at each edge of a mesh with faces (m, 3).

    Rounding decides which of several equally near faces a search names; what is then read off the face would change
    when the model is turned. This makes the choice the same always.
    """

    def __init__(self, faces: IntArray) -> None:
        self._faces = faces
        self._corner_points, first = np.unique(faces, return_index=True)
        self._corner_faces = first // 3
        self._edge_keys, first = np.unique(
            _keys(faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()), return_index=True
        )
        self._edge_faces = first // 3

    def use_first_face(self, faces: IntArray, weights: FloatArray) -> None:
        """Replace, in place, faces (n,) and weights (n, 3) by those of the first face that holds the same place."""
        zero = weights <= ZERO
        zeros = zero.sum(axis=1)
        rows = np.flatnonzero(zeros == 2)
        point = self._faces[faces[rows], weights[rows].argmax(axis=1)]
        faces[rows] = self._corner_faces[np.searchsorted(self._corner_points, point)]
        weights[rows] = self._faces[faces[rows]] == point[:, None]
        rows = np.flatnonzero(zeros == 1)
        gone = zero[rows].argmax(axis=1)
        ends = [(self._faces[faces[rows], (gone + i) % 3], weights[rows, (gone + i) % 3]) for i in (1, 2)]
        key = _keys(ends[0][0], ends[1][0])
        faces[rows] = self._edge_faces[np.searchsorted(self._edge_keys, key)]
        weights[rows] = sum(
            (self._faces[faces[rows]] == point[:, None]) * share[:, None] for point, share in ends
        )


def _keys(start: IntArray, end: IntArray) -> IntArray:
    """Return (n,): one number for each undirected edge."""
    return (np.minimum(start, end) << 32) | np.maximum(start, end)

"""The connected parts of a surface, with what tells them apart at a glance."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.components import connected_components
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Parts"]


class Parts:
    """The parts that faces (m, 3) connect points (p, 3) to, in the order of their first points.

    counts: (c, 2) points and faces. middle: (c, 3) mean of the points; size: (c,) their RMS distance from it.
    moments: (c, 4) second moments of the points along their axes, rising, over size squared, and the mean fourth
    power of their distances from the middle over that of the size.
    """

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        graph = adjacency(unique_edges(faces), len(points))
        label = connected_components(graph)[1]
        used = np.zeros(len(points), bool)
        used[faces] = True
        label[~used] = -1
        present, first = np.unique(label[used], return_index=True)
        rename = np.full(int(label.max(initial=-1)) + 2, -1)
        rename[present[np.argsort(first)]] = np.arange(len(present))
        label = rename[label]
        rows = np.flatnonzero(used)
        self._rows = rows[np.argsort(label[rows], kind="stable")]
        of_face = label[faces[:, 0]] if len(faces) else np.empty(0, np.int64)
        self._faces = faces[np.argsort(of_face, kind="stable")]
        count = len(present)
        held = np.bincount(label[rows], minlength=count)
        faced = np.bincount(of_face, minlength=count)
        self._starts = np.concatenate([[0], np.cumsum(held)])
        self._face_starts = np.concatenate([[0], np.cumsum(faced)])
        self.counts = np.stack([held, faced], axis=1)
        sorted_points, sorted_label = points[self._rows], label[self._rows]
        totals = [np.bincount(sorted_label, axis, count) for axis in sorted_points.T]
        self.middle = np.stack(totals, axis=1) / held[:, None]
        arms = sorted_points - self.middle[sorted_label]
        second = np.empty((count, 3, 3))
        for i in range(3):
            for j in range(3):
                second[:, i, j] = np.bincount(sorted_label, arms[:, i] * arms[:, j], count) / held
        square = np.trace(second, axis1=1, axis2=2)
        self.size = np.sqrt(square)
        square = np.where(square > 0.0, square, 1.0)
        # Fourth powers of very large units would leave the range of numbers.
        reach = np.einsum("ij,ij->i", arms, arms) / square[sorted_label]
        fourth = np.bincount(sorted_label, reach**2, count) / held
        self.moments = np.column_stack([np.linalg.eigvalsh(second) / square[:, None], fourth])

    def __len__(self) -> int:
        return len(self.counts)

    def points(self, part: int) -> IntArray:
        """Return the rows of a part's points, rising."""
        return np.asarray(self._rows[self._starts[part] : self._starts[part + 1]])

    def faces(self, part: int) -> IntArray:
        """Return the faces of a part, in rows of its `points`."""
        own = self._faces[self._face_starts[part] : self._face_starts[part + 1]]
        return np.searchsorted(self.points(part), own)

    def alike(self, least: int) -> list[IntArray]:
        """Return the parts of at least `least` points, grouped by their counts, those of most points first."""
        large = np.flatnonzero(self.counts[:, 0] >= least)
        large = large[np.lexsort((large, self.counts[large, 1], -self.counts[large, 0]))]
        change = (np.diff(self.counts[large], axis=0) != 0).any(axis=1)
        return np.split(large, np.flatnonzero(change) + 1)

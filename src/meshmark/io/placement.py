"""Stored positions seen in the scene: transforms and instances, and the way back.

Formats with a scene (glTF, 3MF) store each position once and show it any number of times. A *placement*
is one such showing: which stored rows, under which affine map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["Affine", "Placement", "place", "pull_back"]

# A map whose smallest stretch is this much below its largest flattens the surface: it cannot be undone.
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Affine:
    """The map x -> linear @ x + offset; linear (3, 3), offset (3,)."""

    linear: FloatArray
    offset: FloatArray

    @staticmethod
    def identity() -> Affine:
        """Return the map that changes nothing."""
        return Affine(np.eye(3), np.zeros(3))

    @property
    def is_identity(self) -> bool:
        """Whether the map changes nothing, exactly."""
        return bool((self.linear == np.eye(3)).all() and (self.offset == 0).all())

    @property
    def is_usable(self) -> bool:
        """Whether the map can be undone: it does not flatten what it shows."""
        stretch = np.linalg.svd(self.linear, compute_uv=False)
        return bool(stretch[2] > _FLAT * stretch[0])

    def after(self, inner: Affine) -> Affine:
        """Return the map that applies `inner` first and this one then."""
        with np.errstate(over="ignore", invalid="ignore"):
            return Affine(self.linear @ inner.linear, self.linear @ inner.offset + self.offset)

    def undone(self, shifts: FloatArray) -> FloatArray:
        """Return the stored displacements (n, 3) that show as these displacements in the scene."""
        inverse: FloatArray = np.linalg.inv(self.linear).astype(np.float64)
        return Affine(inverse, np.zeros(3))(shifts)

    def __call__(self, points: FloatArray) -> FloatArray:
        """Map points (n, 3). Each row is computed alike wherever it stands, to the last bit."""
        if self.is_identity:
            return points
        # Not a matrix product: BLAS may round a row differently depending on its place in the array.
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        rows = [x * a + y * b + z * c + d for (a, b, c), d in zip(self.linear, self.offset, strict=True)]
        return np.stack(rows, axis=1)


@dataclass(frozen=True, eq=False)
class Placement:
    """Stored rows `slots`, (k,) indices, shown in the scene under the map `affine`."""

    slots: IntArray
    affine: Affine


def place(stored: FloatArray, placements: Sequence[Placement]) -> FloatArray:
    """Return the scene positions (n, 3) of all placements, one after the other, of stored rows (s, 3)."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.concatenate([item.affine(stored[item.slots]) for item in placements])


def pull_back(
    stored: FloatArray, placements: Sequence[Placement], before: FloatArray, after: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return where the stored rows should move to, (s, 3), and which of them move, (s,).

    A row shown several times moves by the mean of the displacements of its showings, each taken back
    through its own map. A row none of whose showings moved stays as it is, to the last bit.
    """
    total, shown = np.zeros_like(stored), np.zeros(len(stored))
    moved, start = np.zeros(len(stored), dtype=bool), 0
    for item in placements:
        rows = slice(start, start + len(item.slots))
        start += len(item.slots)
        shift = after[rows] - before[rows]
        moved[item.slots[(shift != 0).any(axis=1)]] = True
        if not item.affine.is_identity:
            shift = item.affine.undone(shift)
        # A placement may show one stored row twice, so plain fancy-index addition would lose some.
        for axis in range(3):
            total[:, axis] += np.bincount(item.slots, shift[:, axis], len(stored))
        shown += np.bincount(item.slots, minlength=len(stored))
    target = stored + total / np.maximum(shown, 1)[:, None]
    return np.where(moved[:, None], target, stored), moved

"""Affine maps of points: how a scene shows what is stored, and one copy of a mesh beside another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["Affine"]

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

    def inverse(self) -> Affine:
        """Return the map that undoes this one, which must be usable."""
        linear: FloatArray = np.linalg.inv(self.linear).astype(np.float64)
        return Affine(linear, -linear @ self.offset)

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

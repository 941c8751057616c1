"""Similarity transforms: turn, uniform scale, shift; composed, inverted, and fitted to pairs of points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import FloatArray

__all__ = ["Similarity", "fit_similarity", "rotation_of"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Similarity:
    """x -> scale * rotation x + shift; rotation (3, 3) is proper, scale is above 0, shift is (3,)."""

    scale: float
    rotation: FloatArray
    shift: FloatArray

    @classmethod
    def identity(cls) -> Similarity:
        """Return the transform that changes nothing."""
        return cls(scale=1.0, rotation=np.eye(3), shift=np.zeros(3))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return the moved points, (n, 3)."""
        return points @ (self.rotation.T * self.scale) + self.shift

    def turn(self, vectors: FloatArray) -> FloatArray:
        """Return directions (n, 3) turned along, their lengths kept."""
        return vectors @ self.rotation.T

    def after(self, first: Similarity) -> Similarity:
        """Return the transform that does `first` and then this one."""
        return Similarity(
            scale=self.scale * first.scale,
            rotation=self.rotation @ first.rotation,
            shift=self.scale * (self.rotation @ first.shift) + self.shift,
        )

    def inverse(self) -> Similarity:
        """Return the transform back."""
        rotation = np.ascontiguousarray(self.rotation.T)
        return Similarity(
            scale=1.0 / self.scale, rotation=rotation, shift=rotation @ self.shift / -self.scale
        )


def fit_similarity(source: FloatArray, target: FloatArray, weights: FloatArray | None = None) -> Similarity:
    """Return the similarity that brings `source` (n, 3) closest to `target` (n, 3), by weighted least squares.

    weights: (n,), not negative, not all zero; all equal by default. Closed form after Umeyama,
    doi:10.1109/34.88573. Raises `InputError` where all source points with weight are one point.
    """
    share = np.full(len(source), 1.0 / max(len(source), 1)) if weights is None else weights / weights.sum()
    from_middle, to_middle = share @ source, share @ target
    arms, goals = source - from_middle, target - to_middle
    spread = float(share @ np.einsum("ij,ij->i", arms, arms))
    if not spread > 0.0:
        raise InputError("the points to fit a similarity to are all one point, expected at least two")
    left, values, right = np.linalg.svd(goals.T @ (arms * share[:, None]))
    sign = np.ones(3)
    if np.linalg.det(left) * np.linalg.det(right) < 0.0:
        sign[2] = -1.0
    rotation = (left * sign) @ right
    scale = max(float(values @ sign), np.finfo(float).tiny) / spread
    return Similarity(scale=scale, rotation=rotation, shift=to_middle - scale * (rotation @ from_middle))


def rotation_of(vector: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) about the direction of `vector` (3,) by its length in radians (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross))

"""Spherical angles of points in a frame, and points turned to other angles with their radius kept."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from meshmark.geometry.frame import Frame
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.scheme import Bits

__all__ = ["Angles", "angles_of", "turned"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Angles:
    """Angles (n, 2) of points: from the frame's third axis, 0 to pi, and around it, -pi to pi; radii (n,)."""

    frame: Frame
    radii: FloatArray
    values: FloatArray

    @property
    def weights(self) -> FloatArray:
        """(n, 2): how well each angle is known where places are equally well known, as an inverse variance."""
        return np.column_stack([self.radii, self.radii * np.sin(self.values[:, 0])]) ** 2

    def quantised(self, bits: Bits, dither: FloatArray, step: float) -> Angles:
        """Return the nearest angles on step * (Z + dither + bit / 2), all (n, 2); none leaves the sphere."""
        at = dither + bits / 2.0
        new = step * (np.round(self.values / step - at) + at)
        polar = new[:, 0]
        polar[polar < 0.0] += step
        polar[polar > np.pi] -= step
        return replace(self, values=new)


def angles_of(points: FloatArray, frame: Frame) -> Angles:
    """Return the angles of points (n, 3) as seen from the origin of a frame."""
    x, y, z = frame.to_canonical(points).T
    flat = np.hypot(x, y)
    return Angles(
        frame=frame, radii=np.hypot(flat, z), values=np.column_stack([np.arctan2(flat, z), np.arctan2(y, x)])
    )


def turned(points: FloatArray, order: IntArray, angles: Angles) -> FloatArray:
    """Return points (p, 3), those of `order` (n,) at the angles (n) at their radii."""
    polar, around = angles.values.T
    unit = np.column_stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)])
    new = points.copy()
    new[order] = angles.frame.to_scene(angles.radii[:, None] * unit)
    return new

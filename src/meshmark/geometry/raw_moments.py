"""Moments of a surface up to the third about the origin, which add up over its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.areas import face_areas
from meshmark.geometry.frame import surface_moments
from meshmark.mesh import FloatArray, IntArray

__all__ = ["RawMoments", "raw_moments"]


@dataclass(frozen=True, eq=False, kw_only=True)
class RawMoments:
    """Integrals over a surface: area, of x (3,), of x x' (3, 3), of x x x (3, 3, 3)."""

    area: float
    first: FloatArray
    second: FloatArray
    third: FloatArray


def raw_moments(points: FloatArray, faces: IntArray) -> RawMoments:
    """Return the moments, exact for flat triangles; raises `InputError` where there is no area."""
    areas = face_areas(points, faces)
    area, centre, second = surface_moments(points, faces, areas)
    corners = [points[faces[:, i]] for i in range(3)]
    total = corners[0] + corners[1] + corners[2]
    # Over a triangle: area / 60 (s s s + the three orders of sum v v s + 2 sum v v v), s the sum of the corners v.
    third = _cubic(areas, total, total, total)
    for corner in corners:
        mixed = _cubic(areas, corner, corner, total)
        third += mixed + mixed.transpose(0, 2, 1) + mixed.transpose(2, 0, 1)
        third += 2.0 * _cubic(areas, corner, corner, corner)
    return RawMoments(
        area=area, first=area * centre, second=area * (second + np.outer(centre, centre)), third=third / 60.0
    )


def _cubic(areas: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return (3, 3, 3): sum over faces of area a b c."""
    pairs = (areas[:, None, None] * a[:, :, None] * b[:, None, :]).reshape(len(areas), 9)
    return np.asarray((pairs.T @ c).reshape(3, 3, 3))

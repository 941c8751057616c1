"""Canonical frame of a surface: where it is, how large and how it is turned (docs/design.md, section 1).

Exact surface moments, so that the frame belongs to the surface and not to its triangulation. Everything the
ownership layer measures is measured in this frame, which makes it invariant to similarity transforms.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import permutations

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.areas import face_areas, sum_at_points
from meshmark.geometry.blocks import LARGE, blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["MIRROR", "Frame", "canonical_frame", "frame_alternatives", "signed_axes", "surface_moments"]

# Axes whose second moments differ by less than this share of their sum may change places under an attack.
SWAP_GAP = 0.04
SIGNS = ((1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1))
# Second moments along an axis count as at least this share of their sum, for a flat model's skewness.
FLAT = 1e-6
# Models below this size, or above its inverse, are refused.
SMALLEST = 1e-100
MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame:
    """A similarity transform between the scene and canonical coordinates.

    centre:  (3,) centroid of the surface.
    scale:   root mean square distance of the surface from its centroid, in scene units.
    axes:    (3, 3) columns are the axes, a rotation.
    moments: (3,) second moments along the axes, falling, sum 1.
    area:    surface area over scale squared.
    skewness: (3,) third moment along each axis over its second to the power 3/2; where it is small, an attack may
             turn the axis round.
    """

    centre: FloatArray
    scale: float
    axes: FloatArray
    moments: FloatArray
    area: float
    skewness: FloatArray = field(default_factory=lambda: np.zeros(3))

    def to_canonical(self, points: FloatArray) -> FloatArray:
        """Scene coordinates (p, 3) -> canonical coordinates (p, 3)."""
        return (points - self.centre) @ (self.axes / self.scale)

    def to_scene(self, points: FloatArray) -> FloatArray:
        """Canonical coordinates (p, 3) -> scene coordinates (p, 3)."""
        return points @ (self.axes.T * self.scale) + self.centre

    def mirrored(self) -> Frame:
        """Return the frame of the mirror image, all x being reversed."""
        axes = MIRROR[:, None] * self.axes
        # Axes point to where the third moments are positive, but for the least, which makes the frame a rotation.
        axes[:, np.argmin(self.skewness * np.maximum(self.moments, FLAT) ** 1.5)] *= -1.0
        return replace(self, centre=MIRROR * self.centre, axes=axes)


def surface_moments(
    points: FloatArray, faces: IntArray, areas: FloatArray | None = None
) -> tuple[float, FloatArray, FloatArray]:
    """Return area, centroid (3,) and central second moments (3, 3) per unit area, exact for flat triangles.

    areas: (m,) of the faces, where they are known already.
    """
    areas = face_areas(points, faces) if areas is None else areas
    total = float(areas.sum())
    if not total > 0.0:
        raise InputError("the model has no surface: all its faces have zero area")
    shares = areas / total
    lumped = sum_at_points(shares, faces, len(points))
    centre = lumped @ points / 3.0
    second = np.zeros((3, 3))
    for part in blocks(len(points), LARGE):
        arm = points[part] - centre
        second += arm.T @ (arm * lumped[part, None])
    for part in blocks(len(faces), LARGE):
        middle = _corner_sum(points, centre, faces[part])
        second += middle @ (middle * shares[part]).T
    return total, centre, second / 12.0


def _corner_sum(points: FloatArray, centre: FloatArray, faces: IntArray) -> FloatArray:
    """Return (3, m): the sum of the three corners of each face, less the centre each, axis by axis."""
    sums = np.empty((3, len(faces)))
    for part in blocks(len(faces)):
        a, b, c = (points.take(faces[part, corner], axis=0) - centre for corner in range(3))
        sums[:, part] = (a + b + c).T
    return sums


def _third_moments(points: FloatArray, faces: IntArray, areas: FloatArray) -> FloatArray:
    """Return (3,): integrals of x^3, y^3, z^3 over the surface (up to a common factor)."""
    moments = np.zeros(3)
    for part in blocks(len(faces), LARGE):
        cubes = np.empty((3, part.stop - part.start))
        for some in blocks(len(cubes[0])):
            a, b, c = (points.take(faces[part][some, corner], axis=0).T for corner in range(3))
            # The integral of x^3 over a triangle is area/10 times the complete homogeneous polynomial h3(a, b, c).
            total = a + b + c
            cubes[:, some] = total * (total * total - 2.0 * (a * b + b * c + c * a)) + a * b * c
        moments += [areas[part] @ cube for cube in cubes]
    return moments


def signed_axes(axes: FloatArray, third: FloatArray) -> FloatArray:
    """Return rotations: of the axes (..., 3, 3) those turned round whose third moment (..., 3) is negative.

    Of a triple that is mirrored then, the axis with the smallest third moment is turned as well.
    """
    signs = np.where(third < 0.0, -1.0, 1.0)
    mirrored = np.linalg.det(axes * signs[..., None, :]) < 0.0
    least = np.argmin(np.abs(third), axis=-1)
    signs *= np.where((np.arange(3) == least[..., None]) & mirrored[..., None], -1.0, 1.0)
    return np.asarray(axes * signs[..., None, :])


def canonical_frame(points: FloatArray, faces: IntArray) -> Frame:
    """Return the frame of a surface.

    The axes are the eigenvectors of the second moments, their signs those of `signed_axes`.
    Raises `InputError` for no surface.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    size = float((high - low).max())
    if not SMALLEST < size < 1.0 / SMALLEST:
        raise InputError(
            f"the model's size is {size:.3g}, expected {SMALLEST:.0e} to {1.0 / SMALLEST:.0e} units"
        )
    middle = low + (high - low) / 2.0
    points = (points - middle) / size  # squares and cubes of any unit stay in range
    areas = face_areas(points, faces)
    area, centre, second = surface_moments(points, faces, areas)
    values, vectors = np.linalg.eigh(second)
    values, axes = values[::-1], vectors[:, ::-1]
    scale = float(np.sqrt(values.sum()))
    if not scale > 0.0:
        raise InputError("the model has no extent: all its surface lies in one point")
    third = _third_moments((points - centre) @ (axes / scale), faces, areas)
    axes = np.ascontiguousarray(signed_axes(axes, third))
    moments = values / values.sum()
    # `_third_moments` leaves out a factor of 10.
    skewness = np.abs(third) / (10.0 * area) / np.maximum(moments, FLAT) ** 1.5
    return Frame(
        centre=middle + size * centre,
        scale=size * scale,
        axes=axes,
        moments=moments,
        area=area / scale**2,
        skewness=skewness,
    )


def frame_alternatives(frame: Frame, exchange: bool = False, surely_skew: float = np.inf) -> Iterator[Frame]:
    """Yield `frame`, then the other turns it may have been mistaken for, likeliest first.

    The four proper sign patterns, without those that turn round an axis more skew than `surely_skew`; with
    `exchange` also those with axes of nearly equal moments exchanged.
    """
    # The sign of the least skew axis follows from the other two.
    sure = frame.skewness > surely_skew
    sure[np.argmin(frame.skewness)] = False
    for order in permutations(range(3)):
        moments = frame.moments[list(order)]
        if order != (0, 1, 2) and (not exchange or (np.diff(moments) > SWAP_GAP).any()):
            continue
        axes = frame.axes[:, list(order)]
        if np.linalg.det(axes) < 0.0:
            axes = axes * np.array([1.0, 1.0, -1.0])
        # What takes the least skew axes to turn round comes first.
        for signs in sorted(SIGNS, key=lambda signs: float(frame.skewness @ (np.array(signs) < 0))):
            flipped = np.array(signs) < 0
            if order == (0, 1, 2) and (flipped & sure).any():
                continue
            turned = np.ascontiguousarray(axes * np.array(signs, dtype=float))
            yield replace(frame, axes=turned)

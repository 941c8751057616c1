"""Centroid and second moments of a surface and how they change with its points, to hold the canonical frame."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["MOMENTS", "frame_moments"]

MOMENTS = 9
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def frame_moments(points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the centroid and the central second moments per unit of area, and their gradient.

    Parameters
    ----------
    points : (p, 3) float array
    faces : (m, 3) int array

    Returns
    -------
    values : (9,) float array
        Centroid x, y, z; moments xx, yy, zz, xy, xz, yz.
    gradient : (9, p, 3) float array
        By each coordinate of each point.
    """
    count = len(points)
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(normal, axis=1)
    area, normal = 0.5 * double, normal / np.maximum(double, 1e-300)[:, None]
    total, summed = area.sum(), corners.sum(axis=1)
    means = [summed[:, axis] / 3.0 for axis in range(3)]
    means += [
        ((corners[:, :, i] * corners[:, :, j]).sum(axis=1) + summed[:, i] * summed[:, j]) / 12.0
        for i, j in _PAIRS
    ]
    values = np.array([area @ mean for mean in means]) / total
    gradient = np.zeros((MOMENTS, count, 3))
    growth = np.zeros((count, 3))  # of the area
    for corner in range(3):
        at = faces[:, corner]
        across = corners[:, (corner + 2) % 3] - corners[:, (corner + 1) % 3]
        grows = 0.5 * np.cross(normal, across)
        for axis in range(3):
            growth[:, axis] += np.bincount(at, grows[:, axis], count)
            for row, mean in enumerate(means):
                change = mean * grows[:, axis] + area * _slope(row, axis, corners[:, corner], summed)
                gradient[row, :, axis] += np.bincount(at, change, count)
    gradient = (gradient - values[:, None, None] * growth) / total
    centre = values[:3].copy()
    for row, (i, j) in enumerate(_PAIRS, start=3):
        values[row] -= centre[i] * centre[j]
        gradient[row] -= centre[i] * gradient[j] + centre[j] * gradient[i]
    return values, gradient


def _slope(row: int, axis: int, corner: FloatArray, summed: FloatArray) -> FloatArray | float:
    """Return how the mean of a face changes with one coordinate of a corner (m, 3)."""
    if row < 3:
        return 1.0 / 3.0 if axis == row else 0.0
    i, j = _PAIRS[row - 3]
    slope: FloatArray | float = 0.0
    if axis == i:
        slope = slope + (corner[:, j] + summed[:, j]) / 12.0
    if axis == j:
        slope = slope + (corner[:, i] + summed[:, i]) / 12.0
    return slope

"""Centroid and second moments of a surface and how they change with its points, to hold the canonical frame."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["frame_moments"]

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def frame_moments(
    points: FloatArray, faces: IntArray, *, with_area: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return the centroid and the central second moments per unit of area, and their gradient.

    Parameters
    ----------
    points : (p, 3) float array
    faces : (m, 3) int array
    with_area : bool
        Also the logarithm of the area.

    Returns
    -------
    values : (9,) or (10,) float array
        Centroid x, y, z; moments xx, yy, zz, xy, xz, yz; with the area, its logarithm.
    gradient : (9, p, 3) or (10, p, 3) float array
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
    after, before = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
    # By coordinate, corner and face; the faces last, which is fastest.
    grows = np.ascontiguousarray(0.5 * np.cross(normal[:, None], before - after).transpose(2, 1, 0))
    slopes = np.ascontiguousarray(
        ((corners + summed[:, None]) * (area / 12.0)[:, None, None]).transpose(2, 1, 0)
    )
    at = faces.T.ravel()

    def by_point(changes: FloatArray) -> FloatArray:
        return np.stack([np.bincount(at, each.ravel(), count) for each in changes], axis=1)

    growth = by_point(grows)  # of the area
    gradient = np.empty((len(means), count, 3))
    for row, mean in enumerate(means):
        change = mean * grows
        if row < 3:
            change[row] += area / 3.0
        else:
            i, j = _PAIRS[row - 3]
            change[i] += slopes[j]
            change[j] += slopes[i]
        gradient[row] = by_point(change)
    gradient = (gradient - values[:, None, None] * growth) / total
    centre = values[:3].copy()
    for row, (i, j) in enumerate(_PAIRS, start=3):
        values[row] -= centre[i] * centre[j]
        gradient[row] -= centre[i] * gradient[j] + centre[j] * gradient[i]
    if with_area:
        return np.append(values, np.log(total)), np.concatenate([gradient, growth[None] / total])
    return values, gradient

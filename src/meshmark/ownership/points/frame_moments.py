"""Centroid and second moments of a surface and how they change with its points, to hold the canonical frame."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import cross_by_axis
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
        By each coordinate of each point; those of all points lie in one piece.
    """
    count, corner = len(points), np.ascontiguousarray(faces.T)
    # By coordinate, corner and face; the faces last, which is fastest.
    ends = np.stack([axis.take(corner) for axis in np.ascontiguousarray(points.T)])
    normal = cross_by_axis(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
    double = np.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
    area, normal = 0.5 * double, normal / np.maximum(double, 1e-300)
    total, summed = area.sum(), ends[:, 0] + ends[:, 1] + ends[:, 2]
    means = [each / 3.0 for each in summed]
    means += [((ends[i] * ends[j]).sum(axis=0) + summed[i] * summed[j]) / 12.0 for i, j in _PAIRS]
    values = np.array([area @ mean for mean in means]) / total
    across = np.roll(ends, 1, axis=1) - np.roll(ends, -1, axis=1)
    grows = 0.5 * cross_by_axis(normal[:, None], across)
    slopes = (ends + summed[:, None]) * (area / 12.0)
    at = corner.ravel()

    def by_point(changes: FloatArray) -> FloatArray:
        return np.stack([np.bincount(at, each.ravel(), count) for each in changes])

    growth = by_point(grows)  # of the area
    gradient = np.empty((len(means) + with_area, 3, count))
    change = np.empty_like(grows)
    for row, mean in enumerate(means):
        np.multiply(mean, grows, out=change)
        if row < 3:
            change[row] += area / 3.0
        else:
            i, j = _PAIRS[row - 3]
            change[i] += slopes[j]
            change[j] += slopes[i]
        gradient[row] = (by_point(change) - values[row] * growth) / total
    centre = values[:3].copy()
    for row, (i, j) in enumerate(_PAIRS, start=3):
        values[row] -= centre[i] * centre[j]
        gradient[row] -= centre[i] * gradient[j] + centre[j] * gradient[i]
    if with_area:
        values, gradient[9] = np.append(values, np.log(total)), growth / total
    return values, gradient.transpose(0, 2, 1)

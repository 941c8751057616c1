"""From where to look at a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["Stance", "from_behind", "level_view", "three_quarter_view"]

AZIMUTH = np.deg2rad(32.0)
ELEVATION = np.deg2rad(17.0)
SAMPLE = 20_000
DOUBT = 0.12
"""Footing that counts for nothing: a figure on two feet stands, though it would lie more broadly."""
UPWARDS = (
    ((0.0, 1.0, 0.0), 1.0),
    ((0.0, 0.0, 1.0), 0.6),
    ((1.0, 0.0, 0.0), 0.35),
    ((-1.0, 0.0, 0.0), 0.35),
    ((0.0, -1.0, 0.0), 0.35),
    ((0.0, 0.0, -1.0), 0.35),
)
"""Directions that may be up, with how likely each is beside the others for the same footing."""


@dataclass(frozen=True, kw_only=True)
class Stance:
    """How a model stands: unit vectors along the file's axes, upwards and out of its front, at right angles."""

    up: tuple[float, float, float]
    front: tuple[float, float, float]


def level_view(points: FloatArray, stance: Stance | None = None) -> FloatArray:
    """Return the rotation (3, 3) with rows right, up, towards the viewer, who stands level in front of the model.

    stance: of the model, where it is known. Otherwise up is the direction of the file's axes in which the model
    stands most broadly, y before z before the rest, and the front is a long side.
    """
    if stance is not None:
        up, front = np.array(stance.up), np.array(stance.front)
        return np.stack([np.cross(up, front), up, front])
    sample = points[:: max(1, len(points) // SAMPLE)]
    sample = sample - sample.mean(axis=0)
    up = np.array(max(UPWARDS, key=lambda way: way[1] * (DOUBT + _footing(sample, np.array(way[0]))))[0])
    flat = sample - np.outer(sample @ up, up)
    _, axes = np.linalg.eigh(flat.T @ flat)
    long = axes[:, 2] * np.where(axes[np.argmax(np.abs(axes[:, 2])), 2] < 0.0, -1.0, 1.0)
    return np.stack([long, up, np.cross(long, up)])


def three_quarter_view(points: FloatArray, stance: Stance | None = None) -> FloatArray:
    """Return `level_view` from `AZIMUTH` to the right and `ELEVATION` above: a rotation (3, 3)."""
    right, up, front = level_view(points, stance)
    level = np.cos(AZIMUTH) * front + np.sin(AZIMUTH) * right
    towards = np.cos(ELEVATION) * level + np.sin(ELEVATION) * up
    right = np.cross(up, level)
    return np.stack([right, np.cross(towards, right), towards])


def from_behind(view: FloatArray) -> FloatArray:
    """Return the view (3, 3) from the other side of a model that `three_quarter_view` shows, from above as well."""
    up = np.cos(ELEVATION) * view[1] + np.sin(ELEVATION) * view[2]
    return np.asarray(view @ (2.0 * np.outer(up, up) - np.eye(3)))


def _footing(points: FloatArray, up: FloatArray) -> float:
    """Return the area of the hull of the lowest 3 % of the height over that of all, seen from above."""
    height = points @ up
    low = height <= height.min() + 0.03 * np.ptp(height)
    above = points[:, up == 0.0]
    return _hull_area(above[low]) / (_hull_area(above) or 1.0)


def _hull_area(flat: FloatArray) -> float:
    from scipy.spatial import ConvexHull, QhullError

    if len(flat) < 3:
        return 0.0
    try:
        return float(ConvexHull(flat).volume)  # the volume of a plane hull is its area
    except QhullError:  # all on one line
        return 0.0

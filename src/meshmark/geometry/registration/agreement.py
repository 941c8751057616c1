"""How well landmarks and a surface agree under a pose, looked at from both sides."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.similarity import Similarity
from meshmark.mesh import FloatArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


__all__ = ["TOLERANCE", "judge"]

TOLERANCE = 0.03
"""A height of this, in units of the reference's scale, is a third of agreement."""
# Surfaces curve: at a distance, heights may be larger by this share of it.
CURVING = 0.1
REACH = 0.3
NEIGHBOURS = 4


def judge(
    landmarks: Landmarks, surfels: Surfels, judges: Surfels, pose: Similarity, tolerance: float = TOLERANCE
) -> tuple[float, float]:
    """Return two shares, each 0 to 1, under a pose (landmarks -> surface).

    Of the landmarks that lie on the surface and face its way, and of the surface (of its pieces `judges`, which are
    spread over it) that lies in the tangent plane of a landmark nearby.
    """
    on_surface = _Oriented(pose(landmarks.places), pose.turn(landmarks.normals))
    share = _agreement(on_surface, surfels, surfels.tree, pose.scale, tolerance)
    back = pose.inverse()
    on_landmarks = _Oriented(back(judges.places), back.turn(judges.normals))
    explained = _agreement(on_landmarks, landmarks, landmarks.tree, 1.0, tolerance)
    return share, explained


class _Oriented(NamedTuple):
    places: FloatArray
    normals: FloatArray


def _agreement(
    these: _Oriented, those: Surfels | Landmarks, tree: cKDTree, unit: float, tolerance: float
) -> float:
    """Return the mean, over `these`, of how well the best of the nearest of `those` continues the surface there."""
    count = min(NEIGHBOURS, len(those))
    distance, rows = tree.query(these.places, range(1, count + 1), distance_upper_bound=REACH * unit)
    found = np.isfinite(distance)
    rows = np.minimum(rows, len(those) - 1)
    facing = those.normals[rows]
    step = these.places[:, None] - those.places[rows]
    height = 0.5 * np.einsum("nki,nki->nk", step, facing + these.normals[:, None])
    same = np.einsum("nki,ni->nk", facing, these.normals)
    allowed = tolerance * unit + CURVING * np.where(found, distance, 0.0)
    good = np.exp(-np.square(height / allowed)) * np.clip(2.0 * same - 0.6, 0.0, 1.0) * found
    return float(good.max(axis=1).mean())

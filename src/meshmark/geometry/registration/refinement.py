"""Refining a similarity between landmarks and a surface: damped Gauss-Newton on heights over tangent planes.

First each landmark is moved to the nearest piece of surface that faces its way, then to where its window says that
it should lie. What has no partner, because it was cut off, gets no weight; a few that disagree get little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.registration.landmarks import WIDTH, Landmarks
from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.registration.windows import look
from meshmark.geometry.similarity import Similarity, rotation_of
from meshmark.mesh import FloatArray

__all__ = ["Fit", "approach", "doubt", "refine"]

# Neighbours looked at for one that faces the right way.
NEIGHBOURS = 4
FACING = 0.4
# Reach of the nearest-piece steps, in units of the frame's scale, one round each.
REACHES = (0.3, 0.2, 0.12, 0.08, 0.06)
# Rounds of looking through windows: at coarse pieces, which is quick, and then at fine ones.
COARSE_ROUNDS, FINE_ROUNDS = 8, 3
# A spread of heights below this, in units of the frame's scale, is not worth resolving.
FINEST = 0.002
# A window counts that sees at least this share of the landmark's surface, facing about the same way.
LEAST_SHARE, SAME_WAY = 0.5, 0.7
# A step needs this much weight, in landmarks.
LEAST_WEIGHT = 8.0
DAMPING = 1e-3
FIXED = 1e-5
# Least standard deviation of heights, in units of the frame's scale, that standard errors are computed with.
UNCERTAIN = 0.003


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """A pose (landmarks -> surface) and what the n landmarks see there.

    heights: (n,) what is left, in units of the landmarks; weights: (n,) 0 to 1, 0 for those without a partner.
    doubt:   standard error of the worst-determined motion, as a mean displacement in units of the landmarks.
    """

    pose: Similarity
    heights: FloatArray
    weights: FloatArray
    doubt: float


def doubt(places: FloatArray, normals: FloatArray) -> float:
    """Return the standard error of the weakest motion that n oriented points determine, infinite below a few.

    Lengths are in units of the frame's scale; a sphere, a plane or a lathed shape gives a large one.
    """
    if len(places) < LEAST_WEIGHT:
        return np.inf
    columns, _ = _motions(places - places.mean(axis=0), normals)
    return UNCERTAIN / _weakest(columns.T @ columns)


def approach(landmarks: Landmarks, surfels: Surfels, pose: Similarity) -> Similarity:
    """Return the pose after a few rounds of moving each landmark to the nearest piece of surface."""
    for reach in REACHES:
        places, normals = pose(landmarks.places), pose.turn(landmarks.normals)
        distance, rows = surfels.tree.query(places, NEIGHBOURS, distance_upper_bound=reach * pose.scale)
        rows = np.minimum(rows, len(surfels) - 1)
        same = np.einsum("nki,ni->nk", surfels.normals[rows], normals) > FACING
        first = np.argmax(same & np.isfinite(distance), axis=1)[:, None]
        found = np.take_along_axis(same & np.isfinite(distance), first, axis=1)[:, 0]
        if found.sum() < LEAST_WEIGHT:
            return pose
        row = np.take_along_axis(rows, first, axis=1)[found, 0]
        facing = surfels.normals[row] + normals[found]
        facing /= np.sqrt(np.einsum("ij,ij->i", facing, facing))[:, None]
        height = np.einsum("ij,ij->i", surfels.places[row] - places[found], facing)
        weights = _robust(height, FINEST * pose.scale)
        pose, _ = _step(pose, _Heights(places=places[found], normals=facing, heights=height, weights=weights))
    return pose


def refine(landmarks: Landmarks, coarse: Surfels, fine: Surfels, pose: Similarity) -> Fit:
    """Return the pose at which the windows around the landmarks see the surface, in pieces, at height zero."""
    fit = Fit(pose=pose, heights=np.zeros(len(landmarks)), weights=np.zeros(len(landmarks)), doubt=np.inf)
    for surfels, rounds in ((coarse, COARSE_ROUNDS), (fine, FINE_ROUNDS)):
        for _ in range(rounds):
            before = fit.pose
            fit = _through_windows(landmarks, surfels, before)
            moved = np.abs(fit.pose(landmarks.places) - before(landmarks.places)).max(initial=0.0)
            if moved < FIXED * before.scale:
                break
    return fit


def _through_windows(landmarks: Landmarks, surfels: Surfels, pose: Similarity) -> Fit:
    """Return the pose after one step, and what the windows saw before it."""
    places, normals = pose(landmarks.places), pose.turn(landmarks.normals)
    seen = look(surfels, places, normals, WIDTH * pose.scale)
    share = np.clip(seen.masses / landmarks.masses, 0.0, 1.0)
    facing = np.einsum("ij,ij->i", seen.facing, normals)
    trust = np.where((share > LEAST_SHARE) & (facing > SAME_WAY), share**2, 0.0)
    weights = trust * _robust(seen.heights, FINEST * pose.scale, trust > 0.0)
    heights = _Heights(
        places=seen.middles,
        normals=normals,
        heights=seen.heights,
        weights=weights,
        drift=landmarks.curvatures,
    )
    after, unsure = _step(pose, heights)
    return Fit(pose=after, heights=seen.heights / pose.scale, weights=weights, doubt=unsure / pose.scale)


def _robust(heights: FloatArray, finest: float, counted: NDArray[np.bool_] | None = None) -> FloatArray:
    """Return Tukey's weights (n,) for a spread taken from the median of the sizes."""
    sizes = np.abs(heights if counted is None else heights[counted])
    if not len(sizes):
        return np.zeros(len(heights))
    limit = 4.685 * max(1.4826 * float(np.median(sizes)), finest)
    return np.asarray(np.clip(1.0 - (heights / limit) ** 2, 0.0, 1.0) ** 2)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Heights:
    """The surface over n tangent planes: places and normals (n, 3), the planes; heights and weights (n,).

    drift: (n,) heights may also follow these numbers times a free factor, as smoothing makes them do; None: not.
    """

    places: FloatArray
    normals: FloatArray
    heights: FloatArray
    weights: FloatArray
    drift: FloatArray | None = None


def _step(pose: Similarity, seen: _Heights) -> tuple[Similarity, float]:
    """Return the pose after one damped Gauss-Newton step, and the standard error of its weakest direction."""
    heights, weights, drift = seen.heights, seen.weights, seen.drift
    total = weights.sum()
    if not total > LEAST_WEIGHT:
        return pose, np.inf
    centre = weights @ seen.places / total
    jacobian, size = _motions(seen.places - centre, seen.normals)
    if drift is not None:
        unit = np.sqrt(weights @ drift**2 / total) or 1.0
        jacobian = np.column_stack([jacobian, drift / unit])
    normal = jacobian.T @ (jacobian * weights[:, None])
    gradient = jacobian.T @ (weights * heights)
    damped = normal + DAMPING * total * np.eye(len(normal)) / len(normal)
    theta = np.linalg.solve(damped, gradient)
    variance = max(weights @ (heights - jacobian @ theta) ** 2 / total, (UNCERTAIN * pose.scale) ** 2)
    turn = rotation_of(theta[3:6] / size)
    growth = float(np.exp(theta[6] / size))
    move = Similarity(scale=growth, rotation=turn, shift=centre + theta[:3] - growth * (turn @ centre))
    return move.after(pose), float(np.sqrt(variance)) / _weakest(normal)


def _motions(arms: FloatArray, normals: FloatArray) -> tuple[FloatArray, float]:
    """Return how fast heights change (n, 7) by shift, turn and growth, and the RMS arm, their unit of length."""
    size = float(np.sqrt(np.einsum("ij,ij->", arms, arms) / len(arms))) or 1.0
    arms = arms / size
    along = np.einsum("ij,ij->i", arms, normals)
    return np.column_stack([normals, np.cross(arms, normals), along]), size


def _weakest(normal: FloatArray) -> float:
    """Return the square root of the smallest eigenvalue of a normal matrix."""
    return float(np.sqrt(max(float(np.linalg.eigvalsh(normal)[0]), np.finfo(float).tiny)))

"""How a whole model lies in a damaged copy of it, to the precision of the copy's coordinates."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.geometry.extent import diagonal
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.similarity import Similarity, fit_similarity
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.same_points import grown_over_faces, same_places

__all__ = ["PlacedWhole", "place_whole"]

# A fit is repeated on the points that lie within this multiple of the median of what is left.
_ROUNDS, _WITHIN = 12, 4.0
# Points are looked for this far off at first, over the diagonal.
_FAR = 1e-2
# A pose is believed that puts this share of the intact points in their places.
_SHARE = 0.5
# Intact points that a pose is fitted to.
_MOST = 20_000
# A copy that was not turned, moved or resized is left where it is: no other pose fits better than by this factor.
_BETTER = 0.9


@dataclass(frozen=True, eq=False, kw_only=True)
class PlacedWhole:
    """A whole model in the place of a damaged copy.

    points: (w, 3) of the whole, in the scene of the copy. match: (p,) the point of the whole that each point of the
    copy is, -1 for none. moved: (p,) which points have one, but do not lie in its place. share: of the intact
    points that do, 0 to 1; rms: how far these lie from it, over the copy's diagonal.
    """

    points: FloatArray
    match: IntArray
    moved: NDArray[np.bool_]
    share: float
    rms: float


def place_whole(
    copy: Surface,
    whole: Surface,
    intact: NDArray[np.bool_],
    guesses: Callable[[], Iterable[Similarity]],
    *,
    same: float,
    within: float,
) -> PlacedWhole | None:
    """Return how the whole lies in the copy; None where it does not.

    Parameters
    ----------
    copy, whole : Surface
        Where both have the same faces, their points are the same one by one.
    intact : (p,) bool array
        Points of the copy that are believed to be in their places; some may not be.
    guesses : callable
        Returns similarities from the whole to the copy, to start from; asked where the faces differ.
    same, within : float
        Over the diagonal: a point so near its place lies in it, and by one so near a pose is found.

    Returns
    -------
    PlacedWhole or None
    """
    rows = np.flatnonzero(intact & copy.used)
    if len(rows) < 3:
        return None
    size = diagonal(copy.points, copy.faces)
    if len(copy.points) == len(whole.points) and np.array_equal(copy.faces, whole.faces):
        pose = _fitted(whole.points[rows], copy.points[rows])
        match = np.arange(len(copy.points))
        if (np.linalg.norm(pose(whole.points) - copy.points, axis=1)[rows] <= within * size).mean() < _SHARE:
            return None
        return _placed(copy, pose(whole.points), rows, match, same)
    some = rows[:: max(len(rows) // _MOST, 1)]
    for guess in guesses():
        found = _approached(guess, whole.points, copy.points[some], _FAR * size)
        if found is None:
            continue
        near = same_places(copy.points, found(whole.points), within * size)
        if (near[rows] >= 0).mean() >= _SHARE:
            match = grown_over_faces(near, copy.faces, whole.faces)
            return _placed(copy, found(whole.points), rows, match, same)
    return None


def _placed(copy: Surface, points: FloatArray, rows: IntArray, match: IntArray, same: float) -> PlacedWhole:
    """Return what a match says; points: (w, 3) of the whole in the scene of the copy; rows: intact points."""
    size = diagonal(copy.points, copy.faces)
    off = np.where(match >= 0, np.linalg.norm(points[match] - copy.points, axis=1), np.inf) / size
    near = off <= same
    intact = off[rows][near[rows]]
    return PlacedWhole(
        points=points,
        match=match,
        moved=(match >= 0) & ~near,
        share=len(intact) / len(rows),
        rms=float(np.sqrt(np.mean(intact**2))) if len(intact) else 0.0,
    )


def _fitted(source: FloatArray, target: FloatArray) -> Similarity:
    """Return the similarity from `source` (n, 3) to `target` that most pairs agree with, or that nothing moved."""
    kept = np.ones(len(source), bool)
    for _ in range(_ROUNDS):
        pose = fit_similarity(source[kept], target[kept])
        off = np.linalg.norm(pose(source) - target, axis=1)
        kept = off <= _WITHIN * np.median(off) + np.finfo(float).eps * np.abs(target).max()
    stays = np.linalg.norm(source - target, axis=1)
    if np.median(off) > _BETTER * np.median(stays):
        return Similarity.identity()
    return pose


def _approached(guess: Similarity, whole: FloatArray, points: FloatArray, far: float) -> Similarity | None:
    """Return the pose after fits to the nearest points; None where points (n, 3) have none nearby."""
    pose, tree = guess, kd_tree(whole)
    for _ in range(_ROUNDS):
        found = tree.query(pose.inverse()(points), distance_upper_bound=far / pose.scale)
        distance, nearest = np.asarray(found[0]), np.asarray(found[1], np.int64)
        there = np.isfinite(distance)
        if there.mean() < _SHARE:
            return None
        try:
            pose = _fitted(whole[nearest[there]], points[there])
        except InputError:
            return None
        far = min(far, 2.0 * _WITHIN * pose.scale * float(np.median(distance[there])) + 1e-12 * far)
    return pose

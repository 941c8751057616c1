"""Which point of a whole model each point of a damaged copy is: by its place, then by the faces around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray

__all__ = ["corner_sets", "grown_over_faces", "same_places"]


def same_places(points: FloatArray, whole: FloatArray, within: float) -> IntArray:
    """Return (p,): for each point (p, 3) the one of `whole` (w, 3) in its place, -1 where there is none.

    In its place is one that is at most `within` off, and each of the two is nearest to the other. Lengths in scene
    units.
    """
    distance, of_whole = kd_tree(whole).query(points, distance_upper_bound=within)
    found, nearest = np.flatnonzero(np.isfinite(distance)), np.asarray(of_whole, np.int64)
    back = kd_tree(points).query(whole[nearest[found]])[1]
    match = np.full(len(points), -1)
    mutual = found[back == found]
    match[mutual] = nearest[mutual]
    return match


def grown_over_faces(match: IntArray, faces: IntArray, whole: IntArray) -> IntArray:
    """Return (p,): a match of points that also has those that were moved, reached over faces.

    Parameters
    ----------
    match : (p,) int array
        The point of the whole that each point is, -1 where that is not known.
    faces : (m, 3) int array
        Of the damaged copy.
    whole : (k, 3) int array
        Of the whole model. Where two corners of a face are known, and the whole has a face on the same side of that
        edge, the third corners are the same point.

    Returns
    -------
    (p,) int array
        Each point of the whole is named at most once.
    """
    match = match.copy()
    count = int(whole.max(initial=-1)) + 1
    keys, across = _edges(whole, count)
    known, first, times = np.unique(keys, return_index=True, return_counts=True)
    across, keys = across[first[times == 1]], known[times == 1]
    start, end, tip = (np.concatenate([np.roll(faces, -k, axis=1)[:, c] for k in range(3)]) for c in range(3))
    while len(keys):
        taken = np.zeros(count, bool)
        taken[match[match >= 0]] = True
        open_ = np.flatnonzero((match[start] >= 0) & (match[end] >= 0) & (match[tip] < 0))
        wanted = match[start[open_]] * count + match[end[open_]]
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        there = (keys[place] == wanted) & ~taken[across[place]]
        tips, names = tip[open_[there]], across[place[there]]
        _, once = np.unique(names, return_index=True)
        if not len(once):
            break
        match[tips[once]] = names[once]
    return _once_each(match)


def _edges(faces: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Return a number for each directed edge of the faces, and the corner across from it."""
    turned = np.concatenate([np.roll(faces, -k, axis=1) for k in range(3)])
    return turned[:, 0] * count + turned[:, 1], turned[:, 2]


def _once_each(match: IntArray) -> IntArray:
    """Return the match without points whose name another one has, too."""
    names, times = np.unique(match[match >= 0], return_counts=True)
    return np.where(np.isin(match, names[times > 1]), -1, match)


def corner_sets(faces: IntArray) -> NDArray[np.void]:
    """Return (m,) values that are equal for faces (m, 3) of the same three points."""
    rows = np.ascontiguousarray(np.sort(faces, axis=1))
    return rows.view([("a", np.int64), ("b", np.int64), ("c", np.int64)]).ravel()

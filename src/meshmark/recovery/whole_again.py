"""Repair of a damaged copy by the whole model: faces as the whole has them, moved points in their places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.repair import Recovered
from meshmark.recovery.same_points import corner_sets

__all__ = ["whole_again"]


def whole_again(
    copy: Surface, altered: NDArray[np.bool_], match: IntArray, points: FloatArray, faces: IntArray
) -> Recovered:
    """Return the copy with the faces of the whole; what is not altered stays bit by bit.

    Parameters
    ----------
    copy : Surface
    altered : (p,) bool array
        Points of the copy that go to their places in the whole.
    match : (p,) int array
        The point of the whole that each is, -1 for one that the whole does not have, which goes.
    points : (w, 3) float array
        Of the whole, in the scene of the copy.
    faces : (k, 3) int array
        Of the whole.

    Returns
    -------
    Recovered
        Points of the copy first, in their order, then those that it did not have.
    """
    kept = (match >= 0) | ~copy.used  # loose points stay
    origin = np.flatnonzero(kept)
    there = match[origin]
    moved = (there >= 0) & altered[origin]
    needed = np.zeros(len(points), bool)
    needed[faces] = True
    needed[there[there >= 0]] = False
    new = np.flatnonzero(needed)
    name = np.full(len(points), -1)
    name[there[there >= 0]] = np.flatnonzero(there >= 0)
    name[new] = len(origin) + np.arange(len(new))
    places = np.where(moved[:, None], points[there], copy.points[origin])
    renamed = name[faces]
    known = np.full(len(copy.points), -1)
    known[origin] = np.arange(len(origin))
    old = corner_sets(known[copy.faces])
    return Recovered(
        points=np.concatenate([places, points[new]]),
        faces=renamed,
        origin=np.concatenate([origin, np.full(len(new), -1)]),
        moved=np.concatenate([moved & (places != copy.points[origin]).any(axis=1), np.zeros(len(new), bool)]),
        added=~np.isin(corner_sets(renamed), old),
        left=0,
    )

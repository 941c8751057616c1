"""Which coordinates of a point carry a bit: those along which it can move with the least change of the surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.points.parameters import FREE, SLIDING, TIES

__all__ = ["chosen_coordinates", "ease_of", "held"]


def ease_of(tensor: FloatArray) -> FloatArray:
    """Return (p, 3, 3): the inverse of the cost of a motion at each point, of the tensors (p, 3, 3) of `Stars`."""
    return np.asarray(np.linalg.inv(tensor + SLIDING * np.eye(3)), dtype=np.float64)


def chosen_coordinates(
    tensor: FloatArray, modes: Sequence[tuple[int, int, int]], first: IntArray, ease: FloatArray | None = None
) -> tuple[NDArray[np.bool_], ...]:
    """Return (p, 3) for each mode: which canonical coordinates of each point carry.

    One after the other the coordinate is taken that the point follows most cheaply, those taken before being held.

    Parameters
    ----------
    tensor : (p, 3, 3) float array
        Of `Stars`, in canonical axes.
    modes : sequence of (flat, crease, corner)
        How many coordinates points carry that can slide in two, one or no direction, each at most 3.
    first : (p,) int array
        0, 1 or 2: the coordinate that is preferred where several are as cheap, as the key says.
    ease : (p, 3, 3) float array, optional
        `ease_of` the tensor, where it is known already.
    """
    count = len(tensor)
    free = np.minimum((np.linalg.eigvalsh(tensor) < FREE).sum(axis=1), 2)
    ease = ease_of(tensor) if ease is None else ease
    bias = TIES[(np.arange(3) - first[:, None]) % 3]
    rank = np.full((count, 3), 3)  # when each is taken
    everyone = np.arange(count)
    for taken in range(max((number for mode in modes for number in mode), default=0)):
        worth = np.einsum("pii->pi", ease) * bias
        worth[rank < taken] = -1.0
        best = worth.argmax(axis=1)
        rank[everyone, best] = taken
        column = ease[everyone, :, best]
        pivot = np.maximum(ease[everyone, best, best], 1e-12)
        ease = ease - column[:, :, None] * (column / pivot[:, None])[:, None, :]
    return tuple(rank < np.array(mode)[2 - free][:, None] for mode in modes)


def held(ease: FloatArray, carried: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return (follow, rest), how points move whose carried coordinates are set or held.

    Parameters
    ----------
    ease : (p, 3, 3) float array
        Inverse of the cost of a motion, positive definite.
    carried : (p, 3) bool array

    Returns
    -------
    follow : (p, 3, 3) float array
        Cheapest motion of a point for a change of its carried coordinates; columns of others are 0.
    rest : (p, 3, 3) float array
        Inverse cost of the motions that leave the carried coordinates as they are.
    """
    follow = np.zeros_like(ease)
    rest = ease.copy()
    patterns = carried @ np.array([1, 2, 4])
    for pattern in np.unique(patterns):
        axes = np.flatnonzero([pattern & 1, pattern & 2, pattern & 4])
        if not len(axes):
            continue
        rows = np.flatnonzero(patterns == pattern)
        columns = ease[rows][:, :, axes]
        lever = columns @ np.linalg.inv(columns[:, axes])
        follow[rows[:, None], :, axes] = lever.transpose(0, 2, 1)
        rest[rows] = 0.0 if len(axes) == 3 else rest[rows] - lever @ columns.transpose(0, 2, 1)
    return follow, rest

"""Distortion compensation: how far each cell goes towards its quantiser's point.

Going only part of the way to a coarser quantiser's point costs less than going the whole way to a fine one, and
under noise tells more (Chen and Wornell 2001, doi:10.1109/18.923725). How far each cell goes is set by what is
seen: all parts of the surface are changed about as visibly, up to a limit. The reader need not know how far each
one went.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["Compensation", "Task"]

ROUNDS = 12
# Weight of the doubled phases, by which the frame is locked, beside the single ones, by which bits are told.
LOCK_WEIGHT = 0.1
# Price of energy. How much the bounds may change in a round; the limit on the ratio at first, and its range.
ENERGY = 0.05
GROWTH = (0.6, 1.3)
LIMIT = (0.8, 0.5, 1.0)
SEARCH_STEPS = 40


@dataclass(frozen=True, eq=False, kw_only=True)
class Task:
    """What is wanted of n cells, and what it costs.

    change: (n,) changes of offset, in spacings, to the points of a quantiser of this step. cost: (n, n) energy of
    changes. locks: (n,) True for cells that are locked by doubled phases. seen: returns for changes (n,) how
    visible they are at each cell, 1 where just noticed, and the share of the surface where they are visible.
    share: the largest such share.
    """

    change: FloatArray
    step: float
    cost: FloatArray
    locks: NDArray[np.bool_]
    seen: Callable[[FloatArray], tuple[FloatArray, float]]
    share: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Compensation:
    """Changes (n,) of offsets, and the cosines (n,) of the phases they leave: 1 where a cell goes the whole way."""

    change: FloatArray
    cosine: FloatArray

    @classmethod
    def of(cls, task: Task) -> Compensation:
        """Return the changes that tell most where no part of the surface is too visible.

        Maximises sum [cos t + w cos 2 t] - (2 pi / step)^2 x' C x / 2, t = 2 pi (change - x) / step, with bounds on
        each x that are lowered where it is too visible, and raised where it might be more so.
        """
        if not len(task.change):
            return cls(change=task.change, cosine=np.ones(0))
        cost = ENERGY / np.median(np.diag(task.cost)) * task.cost
        half = 0.5 * task.step
        most = np.full(len(task.change), half)
        limit, here = LIMIT[0], 0.7 * task.change
        for _ in range(ROUNDS):
            ratio, share = task.seen(here)
            closer = np.clip((task.share / max(share, 1e-3)) ** 0.15, 0.9, 1.1)
            limit = float(np.clip(limit * closer, *LIMIT[1:]))
            most *= np.clip(limit / np.maximum(ratio, 1e-9), *GROWTH)
            most = np.clip(most, 2e-3 * half, half)
            here = _most_telling(task, cost, most, here)
        return cls(change=here, cosine=np.cos(2.0 * np.pi * (task.change - here) / task.step))


def _most_telling(task: Task, cost: FloatArray, most: FloatArray, start: FloatArray) -> FloatArray:
    from scipy.optimize import Bounds, minimize

    turn = 2.0 * np.pi / task.step
    weight = np.where(task.locks, LOCK_WEIGHT, 0.0)

    def value(x: FloatArray) -> tuple[float, FloatArray]:
        phase = turn * (task.change - x)
        force = turn * turn * (cost @ x)
        evidence = np.cos(phase) + weight * np.cos(2.0 * phase)
        slope = np.sin(phase) + 2.0 * weight * np.sin(2.0 * phase)
        return (
            float(0.5 * x @ force - evidence.sum()) / len(x),
            np.asarray(force - slope * turn) / len(x),
        )

    found = minimize(
        value,
        np.clip(start, -most, most),
        jac=True,
        method="L-BFGS-B",
        bounds=Bounds(-most, most),
        options={"maxiter": SEARCH_STEPS},
    )
    return np.asarray(found.x)

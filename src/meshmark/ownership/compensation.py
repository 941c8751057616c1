"""Distortion compensation: how far each cell goes towards its quantiser's point.

Going only part of the way to a coarser quantiser's point costs less than going the whole way to a fine one, and
under noise tells more (Chen and Wornell 2001, doi:10.1109/18.923725). How far each cell goes is set by what is seen:
every part of the surface is changed about as visibly, up to a limit. The reader need not know how far each one went.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership import x_experiment as X

__all__ = ["compensated"]

ROUNDS = int(X.ROUNDS)
LEAST_PRICE, MOST_PRICE = 1e-3, 1e3


def compensated(
    change: FloatArray, step: float, cost: FloatArray, excess: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Return the changes (n,) of offsets that tell most where no cell is too visible.

    Maximises sum [cos t + LOCK_WEIGHT cos 2 t] (step / 2 pi)^2 - x' P C P x / 2, t = 2 pi (change - x) / step, with
    prices P = diag(p), raised where the change is too visible and lowered where it is less so than it may be.

    cost: C (n, n), energy of changes. excess: returns how visible changes (n,) are at each cell, 1 at the limit.
    """
    if not len(change):
        return change
    scaled = cost / np.median(np.diag(cost))
    price = np.full(len(change), 0.5)
    here = change * 0.7
    limit = X.RATIO
    for _ in range(ROUNDS):
        here = _most_telling(change, step, price[:, None] * scaled * price, here)
        seen, share = excess(here)
        limit = np.clip(limit * np.clip((X.SHARE / max(share, 1e-3)) ** 0.15, 0.9, 1.1), 0.5, 1.0)
        seen = np.maximum(seen / limit, 1e-3)
        price = np.clip(price * np.clip(seen, 0.5, 2.0), LEAST_PRICE, MOST_PRICE)
    return here


def _most_telling(change: FloatArray, step: float, cost: FloatArray, start: FloatArray) -> FloatArray:
    from scipy.optimize import minimize

    turn = 2.0 * np.pi / step
    mu = X.MU

    def value(x: FloatArray) -> tuple[float, FloatArray]:
        phase = turn * (change - x)
        force = cost @ x
        told = np.cos(phase) + mu * np.cos(2.0 * phase)
        slope = np.sin(phase) + 2.0 * mu * np.sin(2.0 * phase)
        return (
            float((-told.sum() + 0.5 * turn**2 * x @ force) / len(x)),
            np.asarray((-slope * turn + turn**2 * force) / len(x)),
        )

    return np.asarray(minimize(value, start, jac=True, method="L-BFGS-B", options={"maxiter": 40}).x)

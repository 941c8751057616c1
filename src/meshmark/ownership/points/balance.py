"""Setting some coordinates one step further, so that the frame needs less correction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["balanced"]

# Points that are set further at most.
MOST = 60
# Of a step, tried on either side.
SIDES = np.array([1.0, -1.0])


def balanced(
    motion: FloatArray,
    *,
    follow: FloatArray,
    cost: FloatArray,
    carries: NDArray[np.bool_],
    step: float,
    gradient: FloatArray,
    error: FloatArray,
    price: FloatArray,
) -> FloatArray:
    """Return the motions (p, 3) after steps that save more in the frame than they cost.

    The energy that is lowered is that of the motions plus that of the correction that the frame still needs.

    Parameters
    ----------
    motion : (p, 3) float array
        Of points whose coordinates are set.
    follow : (p, 3, 3) float array
        Motion for a change of each coordinate.
    cost : (p, 3, 3) float array
        Energy of a motion v is v' cost v.
    carries : (p, 3) bool array
        The coordinates that are set.
    step : float
    gradient : (q, p, 3) float array
        Change of the frame's q moments.
    error : (q,) float array
        Of the moments, after the motions.
    price : (q, q) float array
        Energy of correcting an error e is e' price e.
    """
    point, axis = np.nonzero(carries)
    if not len(point):
        return motion
    turns = (step * SIDES[:, None, None] * follow[point, :, axis]).reshape(-1, 3)  # (2 n, 3)
    owner = np.tile(point, 2)
    lever = np.einsum("qni,ni->nq", gradient[:, owner], turns)
    force = np.einsum("nij,nj->ni", cost[owner], turns)
    own = np.einsum("ni,ni->n", force, turns) + np.einsum("nq,qr,nr->n", lever, price, lever)
    energy = own + 2.0 * np.einsum("ni,ni->n", force, motion[owner])
    motion, error = motion.copy(), error.copy()
    for _ in range(MOST):
        saving = energy + 2.0 * lever @ (price @ error)
        best = int(np.argmin(saving))
        if saving[best] >= 0.0:
            break
        motion[owner[best]] += turns[best]
        error += lever[best]
        energy[owner == owner[best]] = np.inf  # each point once
    return motion

"""Setting some coordinates one step further, so that the frame needs less correction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["balanced"]

# Points that are set further at most.
MOST = 60
# What is left out is chosen for an error of this many times that of the frame.
AHEAD = 1.5


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
        Energy of a motion v is v' cost v, of points on kept planes about.
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
    turns = step * follow[point, :, axis]  # (n, 3), to one side; to the other the same backwards
    levers = np.stack([np.einsum("ni,ni->n", each[point], turns) for each in gradient])
    force = np.einsum("nij,nj->ni", cost[point], turns)
    levering = np.maximum(np.einsum("qn,qn->n", price @ levers, levers), 0.0)
    own = np.einsum("ni,ni->n", force, turns) + levering
    rise = 2.0 * np.einsum("ni,ni->n", force, motion[point])
    motion, error = motion.copy(), error.copy()
    reach, rows, some = 0.0, np.zeros(0, np.int64), levers[:, :0]
    for _ in range(MOST):
        wanted = price @ error
        size = max(float(error @ wanted), 0.0) ** 0.5
        if size > reach or not len(rows):
            # Others cost more than they save as long as the error is no larger: by Cauchy and Schwarz.
            reach = AHEAD * size
            rows = np.flatnonzero(own - np.abs(rise) < 2.0 * reach * np.sqrt(levering))
            if not len(rows):
                break
            some = levers[:, rows]
        change = rise[rows] + 2.0 * (wanted @ some)
        saving = own[rows] - np.abs(change)
        place = int(np.argmin(saving))
        if saving[place] >= 0.0:
            break
        side, best = (-1.0 if change[place] > 0.0 else 1.0), rows[place]
        motion[point[best]] += side * turns[best]
        error += side * levers[:, best]
        own[point == point[best]] = np.inf  # each point once
    return motion

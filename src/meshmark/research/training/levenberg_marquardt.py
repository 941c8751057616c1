"""Levenberg-Marquardt training: damped Gauss-Newton with an analytic Jacobian.

See docs/design.md, section 5, and the paper's eq. 14.

For a loss sum_i l_i(z_i) over outputs z_i with derivatives J, the step solves

    (J' diag(l'') J + ridge + mu I) step = -(J' l' + ridge w)

which for squares is Levenberg's and Marquardt's, and for the logistic loss the generalised Gauss-Newton step.
The damping mu follows how well the quadratic model foretold the gain: H. B. Nielsen, Damping parameter in
Marquardt's method (IMM-REP-1999-05, 1999).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from meshmark.mesh import FloatArray

__all__ = ["Normal", "Trained", "levenberg_marquardt"]

FIRST_DAMPING = 1e-3
LARGEST_DAMPING = 1e12


@dataclass(frozen=True, eq=False, kw_only=True)
class Normal:
    """A loss at one point: its value, gradient (p,) and positive semidefinite (generalised) Hessian (p, p)."""

    loss: float
    gradient: FloatArray
    hessian: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Trained:
    """Where training ended.

    weights: (p,) those with the least watched loss; loss: of the training data there; watched: that least loss;
    passes:  accepted steps in all.
    """

    weights: FloatArray
    loss: float
    watched: float
    passes: int


def levenberg_marquardt(
    loss: Callable[[FloatArray], float],
    expand: Callable[[FloatArray], Normal],
    start: FloatArray,
    *,
    watch: Callable[[FloatArray], float] | None = None,
    passes: int = 100,
    patience: int = 10,
    tolerance: float = 1e-10,
) -> Trained:
    """Minimise a loss over weights (p,), from `start`.

    loss, expand: the loss alone, and with its derivatives.
    watch:    the loss of the validation data; training stops after `patience` accepted steps in a row that did
              not lower it, and its best weights are returned. Without it the loss itself is watched.
    passes:   steps tried at most; tolerance: relative gain of an accepted step below which all is done.
    """
    watched = watch or loss
    weights = np.array(start, dtype=np.float64)
    normal = expand(weights)
    best, best_loss, least, since, accepted = weights, normal.loss, watched(weights), 0, 0
    damping = FIRST_DAMPING * max(float(np.diag(normal.hessian).max()), np.finfo(float).tiny)
    raise_by = 2.0
    for _ in range(passes):
        step = _step(normal, damping)
        gain, foretold = -np.inf, 0.0
        if step is not None:
            gain = normal.loss - loss(weights + step)
            foretold = 0.5 * float(step @ (damping * step - normal.gradient))
        if step is None or not gain > 0.0:
            damping, raise_by = damping * raise_by, raise_by * 2.0
            if damping > LARGEST_DAMPING:
                break
            continue
        damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain / foretold - 1.0) ** 3)
        raise_by = 2.0
        weights, accepted = weights + step, accepted + 1
        normal = expand(weights)
        value = watched(weights)
        since += 1
        if value < least:
            best, best_loss, least, since = weights, normal.loss, value, 0
        if since >= patience or gain <= tolerance * abs(normal.loss + gain):
            break
    return Trained(weights=best, loss=best_loss, watched=least, passes=accepted)


def _step(normal: Normal, damping: float) -> FloatArray | None:
    """Return the damped Newton step, or None where the damped Hessian is not positive definite."""
    damped = normal.hessian + damping * np.eye(len(normal.gradient))
    try:
        return np.asarray(-cho_solve(cho_factor(damped), normal.gradient))
    except LinAlgError:
        return None

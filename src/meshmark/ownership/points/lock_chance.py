"""The chance of a lock of points: a bound that counts how exactly the coordinates lie on their places."""

from __future__ import annotations

from math import log
from typing import Final

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["LOOSE", "log10_lock_chance", "log10_loose_chance"]

LOOSE: Final = 0.5
"""Up to this mean resultant length the loose bound serves: of groups of one size it is nearly the other."""
# A fitted frame is the best of the hypotheses that are charged, within this share of the sizes (`lock_grid.FINER`).
_FITTED: Final = 0.03
# Exponents of Chernoff's bound that are tried, over the one that is best for groups of one size.
_EXPONENTS: Final = 2.0 ** np.arange(-2.0, 4.5, 0.5)


def log10_lock_chance(score: float, sizes: FloatArray, *, fitted: bool = False) -> float:
    """Bound log10 of the chance that groups of coordinates reach a score without a mark.

    The key turns the sum of the waves of each group by a uniform angle, and E exp(l z cos) = I_0(l z), so that the
    chance is at most prod I_0(l z_g) exp(-l score) for every l > 0, of which the best of a few is taken. The bound
    exp(-score^2 / sum z^2) follows from it by I_0(x) <= exp(x^2 / 4), and is far above it where all angles are
    small.

    Parameters
    ----------
    score : float
        Sum of the real parts of the sums of the groups.
    sizes : (g,) float array
        Of these sums.
    fitted : bool
        The frame was corrected so that the score is at its top. The corrections that are charged come near to it
        only, and next to exact phases a little of the score is worth much.
    """
    total = float(sizes.sum())
    if score <= 0.0 or total <= 0.0:
        return 0.0
    loose = log10_loose_chance(score, float(sizes @ sizes))
    score -= _FITTED * total if fitted else 0.0
    length = min(score / total, 1.0)
    if length < LOOSE:
        return loose
    from scipy.special import i0e  # takes as long to import as a small model to read

    exponent = _EXPONENTS * (_concentration(length) * np.count_nonzero(sizes) / total)
    scaled = exponent[:, None] * sizes
    bounds = (np.log(i0e(scaled)) + scaled).sum(axis=1) - exponent * score
    return min(loose, float(bounds.min()) / log(10.0))


def log10_loose_chance(score: float, squares: float) -> float:
    """Bound the same by the sum of the squares of the sizes alone."""
    return -(score * score) / (squares * log(10.0)) if score > 0.0 else 0.0


def _concentration(length: float) -> float:
    """Return about the concentration of angles of this mean resultant length, at least `LOOSE`.

    Mardia & Jupp, Directional Statistics (2000), section 5.3.1.
    """
    left = max(1.0 - length, 1e-12)
    if length < 0.85:
        return -0.4 + 1.39 * length + 0.43 / left
    return 1.0 / (left * (2.0 - left - left * left))

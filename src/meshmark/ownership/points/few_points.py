"""The chance of a lock of a handful of coordinates: a bound that counts how exactly they lie on their points."""

from __future__ import annotations

from math import log
from typing import Final

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["log10_lock_chance_of_few"]

# Exponents of Chernoff's bound that are tried, over the mean size.
_EXPONENTS: Final = 2.0 ** np.arange(-3.0, 21.0, 0.25)


def log10_lock_chance_of_few(score: float, sizes: FloatArray) -> float:
    """Bound log10 of the chance that groups of coordinates reach a score without a mark.

    The key turns the sum of the waves of each group by a uniform angle, and E exp(l z cos) = I_0(l z), so that the
    chance is at most prod I_0(l z_g) exp(-l score) for every l > 0, of which the best of a few is taken. The bound
    exp(-score^2 / sum z^2) follows from it, and is far above it where all angles are small.

    Parameters
    ----------
    score : float
        Sum of the real parts of the sums of the groups.
    sizes : (g,) float array
        Of these sums.
    """
    from scipy.special import i0e  # takes as long to import as such a model to read

    total = float(sizes.sum())
    if score <= 0.0 or total <= 0.0:
        return 0.0
    exponent = _EXPONENTS * (len(sizes) / total)
    scaled = exponent[:, None] * sizes
    bounds = (np.log(i0e(scaled)) + scaled).sum(axis=1) - exponent * score
    return min(0.0, float(bounds.min()) / log(10.0))

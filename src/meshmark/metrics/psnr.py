"""Peak signal-to-noise ratio of moved vertices, in dB (DESIGN section 9, eq. 17)."""

from __future__ import annotations

import math

import numpy as np

from meshmark.mesh import Mesh
from meshmark.metrics.displacement import diagonal, rms_over_diagonal

__all__ = ["paper_psnr_db", "psnr_db"]


def psnr_db(a: Mesh, b: Mesh) -> float:
    """Return 20 log10(D / RMSE), D the diagonal of `a`'s bounding box; infinite where nothing moved."""
    return _decibels(rms_over_diagonal(a, b))


def paper_psnr_db(a: Mesh, b: Mesh) -> float:
    """Return the paper's 10 log10(Max / MSE) with both models scaled so that the longest side of `a` is 1.

    Max is then 1 and the square that eq. 17 lacks makes no difference; in any other unit the paper's
    value would depend on the unit. Infinite where nothing moved.
    """
    error = rms_over_diagonal(a, b)
    longest_side = float(np.ptp(a.vertices, axis=0).max())
    return _decibels(error * (diagonal(a) / longest_side))


def _decibels(relative_error: float) -> float:
    """Return -20 log10 of a share; infinite for 0."""
    return -20.0 * math.log10(relative_error) if relative_error else math.inf

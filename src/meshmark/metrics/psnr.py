"""Peak signal-to-noise ratio of a changed model, in dB (docs/design.md, section 9, eq. 17)."""

from __future__ import annotations

import math

import numpy as np

from meshmark.mesh import Mesh
from meshmark.metrics.displacement import diagonal, rms_over_diagonal
from meshmark.metrics.surface_distance import symmetric_rms_over_diagonal

__all__ = ["paper_psnr_db", "psnr_db"]


def psnr_db(a: Mesh, b: Mesh) -> float:
    """Return 20 log10(D / RMSE), D the diagonal of `a`'s bounding box; infinite where nothing moved.

    RMSE is that of the vertices where both models have the same number, else `symmetric_rms_over_diagonal`, the RMS
    distance between the surfaces. Raises `InputError` where a model has no extent or, for other counts, no surface.
    """
    return _decibels(_error(a, b))


def paper_psnr_db(a: Mesh, b: Mesh) -> float:
    """Return the paper's 10 log10(Max / MSE) with both models scaled so that the longest side of `a` is 1.

    Max is then 1 and the square that eq. 17 lacks makes no difference; in any other unit the paper's
    value would depend on the unit. Infinite where nothing moved. MSE and errors as in `psnr_db`.
    """
    error = _error(a, b)
    longest_side = float(np.ptp(a.vertices, axis=0).max())
    return _decibels(error * (diagonal(a) / longest_side))


def _error(a: Mesh, b: Mesh) -> float:
    """Return the RMS error over the diagonal of `a`."""
    if len(a.vertices) == len(b.vertices):
        return rms_over_diagonal(a, b)
    return symmetric_rms_over_diagonal(a, b)


def _decibels(relative_error: float) -> float:
    """Return -20 log10 of a share; infinite for 0."""
    return -20.0 * math.log10(relative_error) if relative_error else math.inf

"""Peak signal-to-noise ratio of an extracted image (docs/design.md, section 11)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from meshmark.errors import InputError

__all__ = ["image_psnr_db"]


def image_psnr_db(sent: ArrayLike, read: ArrayLike) -> float:
    """Return 20 log10(peak / RMSE) of two images in dB; infinite for equal ones.

    Arrays of one shape and type; the peak is the largest value of an integer type (255 for uint8), 1 for bool
    and floating point. Raises `InputError` otherwise.
    """
    a, b = np.asarray(sent), np.asarray(read)
    if a.shape != b.shape or a.dtype != b.dtype or not a.size:
        raise InputError(
            f"images are {a.dtype} {a.shape} and {b.dtype} {b.shape}, expected the same, not empty"
        )
    if a.dtype.kind not in "biuf":
        raise InputError(f"images are {a.dtype}, expected integers, floating point or bool")
    peak = float(np.iinfo(a.dtype).max) if a.dtype.kind in "iu" else 1.0
    error = float(np.sqrt(np.mean(np.square(a.astype(np.float64) - b.astype(np.float64)))))
    return 20.0 * math.log10(peak / error) if error else math.inf

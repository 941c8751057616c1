"""Rates of detection at a stated threshold, and the threshold for a stated false-positive rate (paper eq. 20-21).

A score at or above the threshold says "present".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from meshmark.errors import InputError
from meshmark.mesh import FloatArray

__all__ = ["detection_rate", "present_rate", "threshold_for"]


def present_rate(scores: ArrayLike, threshold: float) -> float:
    """Return the share of scores (n,) at or above the threshold, 0 to 1.

    Of marked models it is the true-positive rate, of unmarked ones or wrong keys the false-positive rate.
    Raises `InputError` without scores.
    """
    return float(np.mean(_scores(scores) >= threshold))


def threshold_for(unmarked: ArrayLike, false_positive_rate: float) -> float:
    """Return the lowest threshold at which at most this share of the unmarked scores (n,) says "present".

    It lies just above a score, or is -inf for a rate of 1. The rate asked for must be at least 1 / n to mean
    anything but "above all seen". Raises `InputError` without scores or for a rate outside 0 to 1.
    """
    if not 0.0 <= false_positive_rate <= 1.0:
        raise InputError(f"false-positive rate {false_positive_rate:g} is out of range, expected 0 to 1")
    falling = np.sort(_scores(unmarked))[::-1]
    allowed = int(np.floor(false_positive_rate * len(falling) * (1.0 + 1e-12)))
    return float(np.nextafter(falling[allowed], np.inf)) if allowed < len(falling) else -np.inf


def detection_rate(marked: ArrayLike, unmarked: ArrayLike, false_positive_rate: float) -> float:
    """Return the true-positive rate at the threshold that the unmarked scores give, 0 to 1."""
    return present_rate(marked, threshold_for(unmarked, false_positive_rate))


def _scores(scores: ArrayLike) -> FloatArray:
    values = np.asarray(scores, np.float64)
    if values.ndim != 1 or not values.size or np.isnan(values).any():
        raise InputError(f"scores have shape {values.shape}, expected (n,) numbers with n at least 1")
    return values

"""Precision, recall and intersection over union of the vertices found altered (docs/design.md, section 11)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshmark.errors import InputError

__all__ = ["iou", "precision", "recall"]


def precision(altered: ArrayLike, found: ArrayLike) -> float:
    """Return the share of the vertices called altered that are, 0 to 1; 1 where none was called so.

    Both (n,) bool, the truth first; raises `InputError` otherwise.
    """
    truth, claim = _pair(altered, found)
    return _share(truth & claim, claim)


def recall(altered: ArrayLike, found: ArrayLike) -> float:
    """Return the share of the altered vertices that were found, 0 to 1; 1 where nothing was altered.

    Both (n,) bool, the truth first; raises `InputError` otherwise.
    """
    truth, claim = _pair(altered, found)
    return _share(truth & claim, truth)


def iou(altered: ArrayLike, found: ArrayLike) -> float:
    """Return the vertices rightly called altered over those altered or called so, 0 to 1; 1 where there are none.

    Both (n,) bool, the truth first; raises `InputError` otherwise.
    """
    truth, claim = _pair(altered, found)
    return _share(truth & claim, truth | claim)


def _share(part: NDArray[np.bool_], whole: NDArray[np.bool_]) -> float:
    return float(part.sum() / whole.sum()) if whole.any() else 1.0


def _pair(altered: ArrayLike, found: ArrayLike) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    truth, claim = np.asarray(altered), np.asarray(found)
    if truth.dtype != np.bool_ or claim.dtype != np.bool_ or truth.ndim != 1 or truth.shape != claim.shape:
        raise InputError(
            f"vertex maps are {truth.dtype} {truth.shape} and {claim.dtype} {claim.shape}, expected bool (n,) twice"
        )
    return truth, claim

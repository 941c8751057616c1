"""How well a payload was read: bit error rate and correlation (paper eq. 19, docs/design.md, section 11)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshmark.errors import InputError

__all__ = ["ber", "correlation", "recovered"]


def ber(sent: ArrayLike, read: ArrayLike) -> float:
    """Return the share of wrong bits, 0 to 1; 0.5 is chance.

    Both (n,) of 0 and 1; raises `InputError` otherwise.
    """
    a, b = _pair(sent, read)
    return float(np.mean(a != b))


def correlation(sent: ArrayLike, read: ArrayLike) -> float:
    """Return the Pearson correlation of two payloads, -1 to 1; 0 is chance.

    Where one of them has all bits alike it has no spread: the value is then 1 for equal payloads, else 0.
    Both (n,) of 0 and 1; raises `InputError` otherwise.
    """
    a, b = (bits.astype(np.float64) - bits.mean() for bits in _pair(sent, read))
    spread = float(np.sqrt((a @ a) * (b @ b)))
    if spread == 0.0:
        return float(ber(sent, read) == 0.0)
    return float(np.clip(a @ b / spread, -1.0, 1.0))


def recovered(sent: ArrayLike, read: ArrayLike) -> float:
    """Return 1 where every bit is right, else 0. Both (n,) of 0 and 1; raises `InputError` otherwise."""
    return float(ber(sent, read) == 0.0)


def _pair(sent: ArrayLike, read: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    a, b = np.asarray(sent), np.asarray(read)
    if a.ndim != 1 or a.shape != b.shape or not a.size:
        raise InputError(
            f"payloads have shapes {a.shape} and {b.shape}, expected equal (n,) with n at least 1"
        )
    for bits in (a, b):
        if not np.isin(bits, (0, 1)).all():
            raise InputError("a payload holds something else than bits, expected 0 and 1")
    return a, b

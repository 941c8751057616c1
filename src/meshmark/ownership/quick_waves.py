"""Cosines and waves in single precision, many times faster: for scores that choose what is looked at again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["quick_cosine", "quick_wave"]

_TURN = np.float32(2.0 * np.pi)


def quick_cosine(turns: FloatArray) -> NDArray[np.float32]:
    """Return the cosine of angles in turns, of any shape, within 1e-6 however many turns they are."""
    return np.asarray(np.cos(_angle(turns)))


def quick_wave(turns: FloatArray) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return cosine and sine of angles in turns, of any shape, within 1e-6 however many turns they are."""
    angle = _angle(turns)
    return np.cos(angle), np.sin(angle)


def _angle(turns: FloatArray) -> NDArray[np.float32]:
    """Return angles in radians within half a turn of 0: what is rounded off is the share of a turn alone."""
    return np.asarray((turns - np.rint(turns)).astype(np.float32) * _TURN)

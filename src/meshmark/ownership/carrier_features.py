"""What the network sees of each carrier: its own doubled phase, its neighbours', and how rough its patch is.

No feature changes when a phase is turned by pi, so none knows the bits; see `demodulator`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.relief import Relief

__all__ = ["FEATURES", "carrier_features"]

FEATURES: Final = (
    "own agreement",
    "log lock",
    "fourfold lock",
    "near agreement",
    "far agreement",
    "shear",
    "log grain",
    "relative grain",
)
# Neighbours count by a Gaussian of this width, in spacings.
NEAR: Final = 1.0
FAR: Final = 2.0
LEAST_LOCK: Final = 0.02
LEAST_GRAIN: Final = 1e-4


def carrier_features(phase: FloatArray, cells: Cells, step: float, relief: Relief) -> FloatArray:
    """Return (n, d), in the order of `FEATURES`, from phases (n,) in radians; step in spacings.

    own agreement: cos(2 phase), 1 on a quantiser point; lock: its mean; fourfold lock: mean cos(4 phase), which
    distinguishes few broken cells from much noise; near, far agreement: how much better than the mean the
    neighbours lie; shear: whether neighbours that face the same way err to the same side; grain: noise expected of
    the patch's roughness, in steps.
    """
    if not len(phase):
        return np.zeros((0, len(FEATURES)))
    wave = np.exp(2j * phase)
    lock = max(float(wave.real.mean()), LEAST_LOCK)
    near, far = (_weights(cells, width) for width in (NEAR, FAR))
    facing = near * np.maximum(cells.normal @ cells.normal.T, 0.0) ** 2
    grain = np.log(relief.grain / step + LEAST_GRAIN)
    ones = np.ones(len(phase))
    return np.column_stack(
        [
            wave.real,
            np.log(lock) * ones,
            np.mean(wave.real**2 - wave.imag**2) * ones,
            _mean_around(near, wave.real, lock) - lock,
            _mean_around(far, wave.real, lock) - lock,
            wave.imag * (facing @ wave.imag) / (facing.sum(axis=1) + 1.0),
            grain,
            grain - np.median(grain),
        ]
    )


def _weights(cells: Cells, width: float) -> FloatArray:
    """Return (n, n): how much each cell counts for each other one, by distance; nothing for itself."""
    place = cells.nodes + cells.offset[:, None] * cells.normal
    square = np.einsum("ij,ij->i", place, place)
    distance = square[:, None] + square - 2.0 * place @ place.T
    weights = np.exp(-0.5 * np.maximum(distance, 0.0) / width**2)
    np.fill_diagonal(weights, 0.0)
    return np.asarray(weights)


def _mean_around(weights: FloatArray, values: FloatArray, prior: float) -> FloatArray:
    """Return (n,): weighted means, drawn to `prior` where there are few neighbours."""
    total = weights.sum(axis=1)
    shrink = 0.5 * float(total.mean()) + 1e-9
    return np.asarray((weights @ values + shrink * prior) / (total + shrink))

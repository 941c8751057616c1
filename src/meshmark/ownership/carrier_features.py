"""What the network sees of each carrier: its doubled phase, pilots and neighbours, and how rough its patch is.

No feature changes when the phase of a cell that carries a bit is turned by pi, so none knows the bits; see
`demodulator`.
"""

from __future__ import annotations

from typing import Final
from weakref import WeakKeyDictionary

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.observation import Observation

__all__ = ["FEATURES", "carrier_features"]

FEATURES: Final = (
    "own agreement",
    "log lock",
    "log pilot lock",
    "fourfold lock",
    "near agreement",
    "far agreement",
    "shear",
    "log grain",
    "relative grain",
)
# Neighbours count by a Gaussian of this width, in spacings.
NEAR: Final = 1.0
FAR: Final = 2.0 * NEAR
LEAST_LOCK: Final = 0.02
LEAST_GRAIN: Final = 1e-4
_KNOWN: Final[WeakKeyDictionary[Cells, tuple[FloatArray, FloatArray, FloatArray]]] = WeakKeyDictionary()


def carrier_features(seen: Observation) -> FloatArray:
    """Return (n, d), in the order of `FEATURES`.

    own agreement: cos(2 phase), 1 on a quantiser point; lock: its mean over cells with bits; pilot lock: mean
    cos(phase) of the pilots; fourfold lock: mean cos(4 phase), which distinguishes few broken cells from much
    noise; near, far agreement: how much better than the mean the neighbours lie, pilots among them by their single
    phases; shear: whether neighbours that face the same way err to the same side; grain: noise expected of the
    patch's roughness, in steps.
    """
    if not len(seen):
        return np.zeros((0, len(FEATURES)))
    cells, pilot = seen.cells, seen.keys.pilot
    doubled = np.cos(2.0 * seen.phase)
    wave = np.exp(1j * seen.psi)
    lock = max(float(doubled[~pilot].mean()) if not pilot.all() else 0.0, LEAST_LOCK)
    pilots = max(float(wave.real[pilot].mean()) if pilot.any() else 0.0, LEAST_LOCK)
    # A cell's agreement beside what is expected of its kind.
    rest = wave.real - np.where(pilot, pilots, lock)
    near, far, facing = _weights(cells)
    grain = np.log(seen.relief.grain / seen.step + LEAST_GRAIN)
    ones = np.ones(len(seen))
    return np.column_stack(
        [
            doubled,
            np.log(lock) * ones,
            np.log(pilots) * ones,
            np.mean(np.cos(4.0 * seen.phase[~pilot])) * ones if not pilot.all() else 0.0 * ones,
            _mean_around(near, rest),
            _mean_around(far, rest),
            wave.imag * (facing @ wave.imag) / (facing.sum(axis=1) + 1.0),
            grain,
            grain - np.median(grain),
        ]
    )


def _weights(cells: Cells) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (n, n) thrice: how much each cell counts for each other one, by distance; nothing for itself.

    The first by a Gaussian of width `NEAR`, the second by one of twice that, whose fourth power the first is; the
    third is the first, less where cells face other ways. Several readings of one measurement come one after the
    other: the last ones are kept as long as their cells.
    """
    known = _KNOWN.get(cells)
    if known is None:
        place = cells.nodes + cells.offset[:, None] * cells.normal
        square = np.einsum("ij,ij->i", place, place)
        distance = square[:, None] + square - 2.0 * place @ place.T
        far = np.exp(np.minimum((-0.5 / FAR**2) * distance, 0.0))
        np.fill_diagonal(far, 0.0)
        near = far * far
        near *= near
        known = near, far, near * np.maximum(cells.normal @ cells.normal.T, 0.0) ** 2
        _KNOWN.clear()
        _KNOWN[cells] = known
    return known


def _mean_around(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return (n,): weighted means, drawn to 0 where there are few neighbours."""
    total = weights.sum(axis=1)
    return np.asarray((weights @ values) / (total + 0.5 * float(total.mean()) + 1e-9))

"""Whether phases agree place by place, whatever the frame: a frame that is turned a little does not hide it.

The least or largest coordinates of several copies have another frame than a copy: at the ends of a model a turn of
a few milliradians moves coordinates by steps. Within a small box all of them are moved alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["coherence"]

ComplexArray = NDArray[np.complex128]

# Edges of boxes, in canonical units: small ones bear larger turns, large ones hold more where points are few.
BOXES = (0.12, 0.25)


def coherence(places: FloatArray, axis: IntArray, phase: FloatArray, group: IntArray) -> float:
    """Return by how many standard deviations of chance phases agree with those of their axis in their box, at best.

    Parameters
    ----------
    places : (n, 3) float array
        Where each coordinate is, canonical units.
    axis : (n,) int array
    phase : (n,) float array
        Radians.
    group : (n,) int array
        Coordinates with one number share what the key says: they agree by themselves, and count as one.
    """
    _, first, row = np.unique(group, return_index=True, return_inverse=True)
    wave = _summed(row, np.exp(1j * phase))
    return max(_coherence(np.column_stack([places[first] / box, axis[first]]), wave) for box in BOXES)


def _coherence(boxes: FloatArray, wave: ComplexArray) -> float:
    """Return the coherence of waves (n,) in the boxes that the integer parts of some numbers (n, 4) name."""
    _, row = np.unique(np.floor(boxes), axis=0, return_inverse=True)
    row, power = row.ravel(), np.abs(wave) ** 2
    own = np.bincount(row, power)  # what is expected of the square of a box's sum, and its variance
    variance = float((own**2 - np.bincount(row, power**2)).sum())
    excess = float((np.abs(_summed(row, wave)) ** 2 - own).sum())
    return excess / float(np.sqrt(variance)) if variance > 0.0 else 0.0


def _summed(row: IntArray, wave: ComplexArray) -> ComplexArray:
    return np.bincount(row, wave.real) + 1j * np.bincount(row, wave.imag)

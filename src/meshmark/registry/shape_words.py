"""The words of shape descriptors: pieces of surface as they typically are, the same on every machine.

A piece is told by 12 numbers (`shape_descriptor`). The words are drawn from a normal distribution with the means,
deviations and correlations of these numbers on 345 training shapes, by a hash instead of a random generator:
descriptors of different years must be of the same words.
"""

from __future__ import annotations

from functools import cache
from hashlib import shake_256
from typing import Final

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["DEVIATIONS", "MEANS", "WORDS", "words"]

WORDS: Final = 512
"""How many there are."""
MEANS: Final = (1.02, 0.19, 0.39, 0.16, 1.05, 0.22, 0.38, 0.18, 1.06, 0.26, 0.35, 0.19)
DEVIATIONS: Final = (0.11, 0.10, 0.09, 0.10, 0.18, 0.11, 0.10, 0.10, 0.25, 0.11, 0.10, 0.09)
"""Of the 12 numbers."""
# Cholesky factor of their correlations, row by row.
_FACTOR: Final = (
    (1.00,),
    (-0.26, 0.96),
    (0.64, -0.34, 0.69),
    (0.59, 0.46, -0.21, 0.63),
    (0.70, -0.12, 0.18, 0.27, 0.62),
    (-0.33, 0.60, 0.05, 0.11, -0.01, 0.72),
    (0.42, -0.43, 0.45, -0.03, 0.39, -0.17, 0.50),
    (0.44, 0.14, -0.01, 0.45, 0.51, 0.26, -0.19, 0.47),
    (0.52, -0.18, 0.18, 0.15, 0.64, -0.07, 0.13, 0.14, 0.43),
    (-0.30, 0.35, 0.04, 0.01, -0.18, 0.57, 0.10, 0.09, 0.12, 0.63),
    (0.30, -0.34, 0.25, -0.08, 0.38, -0.28, 0.44, -0.00, 0.27, -0.10, 0.48),
    (0.29, -0.08, 0.07, 0.19, 0.45, 0.08, 0.04, 0.46, 0.40, 0.18, -0.12, 0.49),
)


@cache
def words() -> FloatArray:
    """Return the words (512, 12), in deviations from the means."""
    from scipy.special import ndtri

    size = len(MEANS)
    drawn = np.frombuffer(shake_256(b"meshmark shape words 1").digest(4 * WORDS * size), "<u4")
    uniform = (drawn.reshape(WORDS, size) + 0.5) / 2.0**32
    factor = np.zeros((size, size))
    for row, values in enumerate(_FACTOR):
        factor[row, : len(values)] = values
    return np.asarray(ndtri(uniform) @ factor.T, np.float64)

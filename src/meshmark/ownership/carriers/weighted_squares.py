"""Sums of weighted squares of the rows of one matrix, for many sets of weights: the Hessians of Newton's steps."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["WeightedSquares"]


class WeightedSquares:
    """The matrices sum_i w_i r_i r_i' of the rows r_i of a matrix (n, d); all sets of weights by one product."""

    def __init__(self, rows: FloatArray) -> None:
        count, self._size = rows.shape
        self._products = (rows[:, :, None] * rows[:, None, :]).reshape(count, self._size**2)

    def __call__(self, weights: FloatArray) -> FloatArray:
        """Return the matrices (k, d, d) of k sets of weights (k, n)."""
        return np.asarray((weights @ self._products).reshape(-1, self._size, self._size))

"""Values on a surface spread over a grid of smooth functions around it: quadratic B-splines."""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = ["spline_weights"]


def spline_weights(points: FloatArray, pitch: float) -> sp.csr_array:
    """Return (p, m): the value at each point (p, 3) of each B-spline of a cubic grid that reaches any of them.

    Products of three quadratic B-splines of knots `pitch` apart, in the unit of `points`: 27 reach each point,
    their values add up to 1, and sums of them have continuous slopes.
    Source: de Boor, A Practical Guide to Splines, chapter IX.
    """
    nearest = np.floor(points / pitch + 0.5)
    away = points / pitch - nearest
    one_axis = np.stack([0.5 * (0.5 - away) ** 2, 0.75 - away**2, 0.5 * (0.5 + away) ** 2])
    around = np.array(list(product((0, 1, 2), repeat=3)))
    values = one_axis[around[:, 0], :, 0] * one_axis[around[:, 1], :, 1] * one_axis[around[:, 2], :, 2]
    columns, count = _columns(nearest.astype(np.int64), around)
    starts = np.arange(len(points) + 1) * len(around)
    return sp.csr_array((values.T.ravel(), columns.ravel(), starts), shape=(len(points), count))


def _columns(nearest: IntArray, around: IntArray) -> tuple[NDArray[np.int32], int]:
    """Number the nodes around each point's nearest one (p, 3); return (p, 27) numbers and how many there are."""
    nearest = nearest - nearest.min(axis=0)
    sizes = nearest.max(axis=0) + 3
    strides = np.array([sizes[1] * sizes[2], sizes[2], 1])
    homes, home_of = np.unique(nearest @ strides, return_inverse=True)
    nodes, numbers = np.unique(homes[:, None] + around @ strides, return_inverse=True)
    return numbers.reshape(-1, len(around)).astype(np.int32)[home_of], len(nodes)

"""Fitting the label map: linear discriminants of models against what attacks do to one model.

The discriminants are the generalised eigenvectors of the covariance of models and that of drifts (Fisher 1936,
10.1111/j.1469-1809.1936.tb02137.x), both robust. Of each drift the restoration counts that lies nearest to the
truth, since a reader tries them all. All bins are equally wide against the drift, and as narrow as the wanted
chance that two models share a label demands.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.linalg import eigh

from meshmark.errors import InputError
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.lattice_label import LabelMap

__all__ = ["SHARED", "collision", "fit_label_map"]

# Wanted chance that two models share a label.
SHARED: Final = 2.0**-12
# Degrees of freedom of Student's distribution by which drifts are weighted: a few wild ones do not decide.
FREEDOM: Final = 30.0
# Models further from the median than this number of standard deviations count as if they lay there.
OUTLYING: Final = 4.0
# Added to the covariance of drifts: shares of its own diagonal, and of the covariance of models.
RIDGE: Final = (1e-3, 1e-5)
NORMAL_MAD: Final = 1.4826
CORE: Final = 0.68
PASSES, WEIGHINGS, HALVINGS, SHIFTS = 5, 6, 20, 100
WIDEST_LOG2: Final = 8.0


def fit_label_map(
    models: FloatArray, changes: Sequence[FloatArray], components: int, shared: float = SHARED
) -> LabelMap:
    """Return the map.

    models:     (n, d) invariants of models that are no copies of each other.
    changes:    for each attacked model (k, d), a row for each restoration.
    components: number of coordinates, at most d.
    shared:     wanted chance that two models share a label.

    Raises `InputError` where there are too few models or changes for a covariance.
    """
    width = models.shape[1]
    if len(models) <= width or len(changes) <= width or not 1 <= components <= width:
        raise InputError(
            f"{len(models)} models, {len(changes)} changes and {components} components, "
            f"expected more than {width} of the first two and at most that number of the last"
        )
    unit = NORMAL_MAD * np.median(np.abs(models - np.median(models, axis=0)), axis=0) + np.finfo(float).eps
    spread = np.clip((models - np.median(models, axis=0)) / unit, -OUTLYING, OUTLYING)
    between = np.cov(spread.T)
    drift = _nearest(changes, np.eye(width)) / unit
    within = np.diag((drift**2).mean(axis=0))
    axes = np.eye(width)
    for _ in range(PASSES):
        for _ in range(WEIGHINGS):
            floor = RIDGE[0] * np.diag(np.diag(within)) + RIDGE[1] * between
            square = np.einsum("ni,ij,nj->n", drift, np.linalg.inv(within + floor), drift) / width
            weight = (FREEDOM + 1.0) / (FREEDOM + square)
            within = (drift * weight[:, None]).T @ drift / len(drift)
        floor = RIDGE[0] * np.diag(np.diag(within)) + RIDGE[1] * between
        axes = eigh(between, within + floor)[1][:, ::-1][:, :components]
        drift = _nearest(changes, axes / unit[:, None]) / unit
    coordinates = drift @ axes
    matrix = axes / unit[:, None] / np.quantile(np.abs(coordinates), CORE, axis=0)
    return LabelMap(matrix / _bin_width(models @ matrix, shared))


def collision(coordinates: FloatArray, rng: np.random.Generator, shifts: int = SHIFTS) -> float:
    """Return the chance that two different rows of (n, c) share all bins of width 1, over random shifts."""
    count, pairs = len(coordinates), 0
    for _ in range(shifts):
        bins = np.floor(coordinates + rng.random(coordinates.shape[1]))
        alike = np.unique(bins, axis=0, return_counts=True)[1].astype(np.int64)
        pairs += int((alike * (alike - 1)).sum())
    return pairs / (shifts * count * (count - 1))


def _nearest(changes: Sequence[FloatArray], toward: FloatArray) -> FloatArray:
    """Return (n, d): of each change (k, d) the row nearest to 0 as seen `toward` some directions (d, c).

    Large coordinates count by their logarithms: one that is far out is lost, how far does not matter.
    """
    return np.array([rows[np.argmin(np.log1p((rows @ toward) ** 2).sum(axis=1))] for rows in changes])


def _bin_width(coordinates: FloatArray, shared: float) -> float:
    """Return the largest width with which two models share a label no more often than wanted."""
    low, high = 0.0, WIDEST_LOG2
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        often = collision(coordinates / 2.0**middle, np.random.default_rng(7)) > shared
        low, high = (low, middle) if often else (middle, high)
    return float(2.0**low)

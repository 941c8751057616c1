"""Fuzzy c-means of feature vectors (Bezdek 1981), with exponent 2."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.research.schemes.clusters import memberships

__all__ = ["fuzzy_c_means"]

PASSES, STILL = 100, 1e-6


def fuzzy_c_means(features: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return centres (count, d) of the rows (n, d), shortest first, and how much each row is of them (n, count).

    The start is at equal quantiles of the rows' lengths, so that nothing is random.
    """
    lengths = np.linalg.norm(features, axis=1)
    quantiles = ((np.arange(count) + 0.5) / count * len(features)).astype(int)
    centres = features[np.argsort(lengths, kind="stable")[quantiles]]
    for _ in range(PASSES):
        weights = memberships(features, centres) ** 2
        moved = weights.T @ features / weights.sum(axis=0)[:, None]
        step, centres = float(np.abs(moved - centres).max()), moved
        if step <= STILL * lengths.max():
            break
    order = np.argsort(np.linalg.norm(centres, axis=1), kind="stable")
    return centres[order], memberships(features, centres)[:, order]

"""Which share of the checks failed around each point: how much of an alteration there is, not only whether."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.authentication.checks.checks import Checks
from meshmark.mesh import FloatArray

__all__ = ["failed_share"]

_STEPS = 3
"""Edges from a point to the farthest checks that are counted there; nearer ones count more."""


def failed_share(graph: csr_array, checks: Checks, altered: NDArray[np.bool_]) -> FloatArray:
    """Return (p,): failed checks over all, each spread over its neighbourhood; 0 to 1, NaN where there are none.

    Parameters
    ----------
    graph : (p, p) sparse matrix
        The vertex graph of the suspect's surface.
    checks : Checks
    altered : (p,) bool array
        The points that the map shows as altered; what was laid bare or made new is among them, checked or not.
    """
    checked = checks.eligible | checks.verified
    if not checked.any():
        return np.full(len(altered), np.nan)
    counts = np.stack([checked & altered, checked], axis=1).astype(np.float64)
    counts += altered[:, None] & ~checked[:, None]
    for _ in range(_STEPS):
        counts += graph @ counts
        counts /= np.maximum(counts.max(), 1.0)  # only the quotient counts
    failed, total = counts.T
    return np.asarray(np.where(total > 0.0, failed / np.where(total > 0.0, total, 1.0), np.nan))

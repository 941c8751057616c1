"""Which marks that hold also lie where they were: parts that were moved whole, or pasted, are found here.

A part that is moved as one keeps the marks inside it. But it hangs together with the rest by no mark that
holds, and some of its marks say where in the model they belong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.authentication.checks.model_frame import DOUBTS, Evidence, ModelFrame, fit_frame
from meshmark.geometry.components import connected_components
from meshmark.mesh import IntArray

__all__ = ["InPlace", "in_place"]

# A part was moved where this number of its fine marks, and this share of them, lie elsewhere.
_ELSEWHERE, _SHARE = 2, 0.25


@dataclass(frozen=True, eq=False, kw_only=True)
class InPlace:
    """believed: (p,) the marks that hold and lie where they were. frame: of the marked model, None: not known."""

    believed: NDArray[np.bool_]
    frame: ModelFrame | None


def in_place(
    edges: IntArray,
    passed: NDArray[np.bool_],
    pairs: IntArray,
    failing: NDArray[np.bool_],
    evidence: Evidence,
    *,
    lucky: int = 0,
) -> InPlace:
    """Return which of the marks that hold to believe, and where the model lies according to them.

    Marks that share points of their rings are one part. The largest part is believed; another one where most of its
    own evidence agrees with the largest part's, or, without any, where it touches nothing that fails: a connected
    component of its own. A mark that says that it lies far from where it does is believed in no part.

    Parameters
    ----------
    edges : (e, 2) int array
        Of the surface.
    passed : (p,) bool array
        The marks that hold.
    pairs : (n, 2) int array
        Each mark that holds and a point of its ring.
    failing : (p,) bool array
        Points that no mark vouches for, though one should.
    evidence : Evidence
        Where marks say that they lie.
    lucky : int
        Number of marks of a part that may hold by chance although they lie elsewhere.

    Returns
    -------
    InPlace
    """
    part = _parts(pairs, len(passed))
    count = int(part.max(initial=-1)) + 1
    if not passed.any():
        return InPlace(believed=passed, frame=None)
    main = int(np.bincount(part[passed], minlength=count).argmax())
    frame = fit_frame(evidence, part[evidence.vertex] == main)
    agrees, moved, lost = _votes(part, frame, evidence, count, lucky)
    touched = np.zeros(count, bool)
    for start, end in (edges.T, edges[:, ::-1].T):
        touched[part[start[failing[end] & ~failing[start]]]] = True
    touched[part[failing]] = True
    believed = ~moved & (agrees >= np.where(touched, 2, 0))
    believed[main] = True
    found = passed & believed[part]
    found[evidence.vertex[lost]] = False
    return InPlace(believed=found, frame=frame)


def _parts(pairs: IntArray, count: int) -> IntArray:
    graph = csr_array((np.ones(len(pairs), np.int8), pairs.T), shape=(count, count))
    return connected_components(graph)[1]


def _votes(
    part: IntArray, frame: ModelFrame | None, evidence: Evidence, count: int, lucky: int
) -> tuple[IntArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return how many coarse marks of each part lie where the largest part puts them, whether the part was moved,
    and which marks (e,) lie far from where they say.
    """
    if frame is None:
        nothing = np.zeros(count, bool)
        return np.zeros(count, np.int64), nothing, np.zeros(len(evidence.vertex), bool)
    off, allowed = frame.off(evidence), frame.allowed(evidence, DOUBTS)
    right, where, fine = off <= allowed, part[evidence.vertex], evidence.fine
    # Where the fit is no better than half a period, a fine mark is right wherever it lies.
    agree = np.bincount(where[right & ~fine], minlength=count)
    dispute = np.bincount(where[~right & ~fine], minlength=count)
    total = np.bincount(where[fine], minlength=count)
    elsewhere = np.bincount(where[~right & fine], minlength=count)
    moved = dispute > agree + lucky
    moved |= (elsewhere >= _ELSEWHERE + lucky) & (elsewhere > _SHARE * total)
    return agree, moved, frame.far(evidence)

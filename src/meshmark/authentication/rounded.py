"""Whether marks fail because the whole model was rounded, and what was changed beyond that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.coarse_digits import coarse_digits
from meshmark.authentication.examination import Examination
from meshmark.geometry.components import connected_parts
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, Mesh

__all__ = ["Requantised", "Rounded", "requantised", "rounded_everywhere"]

# Sizes of the groups of neighbouring points that are looked at; the chance, among all groups, below which the
# failures of one are no rounding; and the number of points that a lost mark leaves without one.
_GROUPS, _CHANCE, _TOGETHER = (32, 64, 128), 1e-3, 4
# A grid this much coarser than the error that marks were made for, as they tell it, is what they were made for.
_SAME = 1.3
# Points that one of those without a mark may stand for; fewest places where points were removed by simplification,
# fewest where their number is not known, and the most of the altered points that lie in one of them.
_REMOVED, _PLACES, _MANY, _IN_ONE = 2.0, 2, 10, 0.8
# Where more of the points fail, what else was changed cannot be decided.
_MOST = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Rounded:
    """called: what the model was rounded to. beyond: (n,) vertices that were changed beyond that.

    clear: enough marks hold to decide whether more was changed than lies off the grid.
    """

    called: str
    beyond: NDArray[np.bool_]
    clear: bool


@dataclass(frozen=True, kw_only=True)
class Requantised:
    """An export that rounded positions no more coarsely than the marks bear.

    bits: of its grid, None: not known. simplified: points were removed here and there, too.
    """

    bits: int | None
    simplified: bool = False


def requantised(mesh: Mesh, found: Examination) -> Requantised | None:
    """Return what an export did to the positions of a model whose marks bear it; None where it did nothing.

    The grid is not known where each mesh of a scene has its own, or the model was turned since.
    """
    if not (found.marked and found.checks.requantised):
        return None
    coarse = coarse_digits(mesh.vertices)
    return Requantised(bits=None if coarse is None else coarse.bits, simplified=_simplified(found))


def _simplified(found: Examination) -> bool:
    """Return whether points were removed here and there, and nothing else need explain what fails.

    Each leaves points around it without a mark, in several places. One place with most of them is an edit, and a
    part of its own that is gone leaves none. Where so much fails that the payload is not read, the number of points
    is not known, and there must be many places.
    """
    missing, checks = found.points_missing, found.checks
    known = found.payload is not None
    failing = int((checks.eligible & ~checks.verified).sum())
    if checks.new_boundary.any() or (known and not 0 < (missing or 0) <= _REMOVED * failing):
        return False
    altered = found.altered
    if not altered.any():
        return known
    count = np.bincount(connected_parts(found.surface.graph, altered)[altered])
    return bool(len(count) >= (_PLACES if known else _MANY) and count.max() <= _IN_ONE * altered.sum())


def rounded_everywhere(mesh: Mesh, found: Examination) -> Rounded | None:
    """Return the rounding of the coordinates that explains why marks fail; None where none does.

    It does where it is coarser than what the marks were made for. An edit is found all the same: it lies off the
    grid, or far more fails around it than elsewhere.
    """
    if not found.marked or found.checks.new_boundary.any() or found.points_missing:
        return None
    coarse = coarse_digits(mesh.vertices)
    if coarse is None or coarse.half <= _SAME * found.checks.error:
        return None
    of_vertex = found.surface.point_of_vertex
    off = np.zeros(len(found.surface.points), bool)
    off[of_vertex[coarse.off]] = True
    rows = np.flatnonzero(found.checks.eligible & ~off)
    failing = ~found.checks.verified[rows]
    clear = len(rows) >= 2 * max(_GROUPS) and float(failing.mean()) <= _MOST
    if clear:
        off[rows[_crowded(found.surface.points[rows], failing)]] = True
    return Rounded(called=coarse.called, beyond=(off & found.altered)[of_vertex], clear=clear)


def _crowded(points: FloatArray, failing: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (r,): which of `points` (r, 3) lie in a group of which far more are `failing` (r,) than of all."""
    from scipy.stats import binom  # takes longer to import than all the rest

    tree, share = kd_tree(points), float(failing.mean())
    crowded = np.zeros(len(points), bool)
    for size in _GROUPS:
        near = np.asarray(tree.query(points, k=size)[1])
        count = failing[near].sum(axis=1) // _TOGETHER
        many = binom.sf(count - 1, size // _TOGETHER, share) < _CHANCE / len(points)
        crowded[near[many].ravel()] = True
    return crowded

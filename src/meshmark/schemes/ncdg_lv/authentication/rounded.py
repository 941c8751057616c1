"""Whether marks fail because the whole model was rounded, and what was changed beyond that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.stats import binom

from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.authentication.coarse_digits import coarse_digits
from meshmark.schemes.ncdg_lv.authentication.examination import Examination
from meshmark.schemes.ncdg_lv.authentication.parameters import UNIT

__all__ = ["Rounded", "rounded_everywhere"]

# As many points are looked at together, and fewer of their marks hold by chance this seldom anywhere.
_NEAR, _CHANCE = 64, 1e-3
# Where fewer of the marks that there were hold, what else was changed cannot be told from rounding. About so many
# of the points carried marks.
_HOLD, _MARKS = 0.25, 0.29


@dataclass(frozen=True, eq=False)
class Rounded:
    """called: what the model was rounded to. beyond: (p,) points around which far fewer marks hold than elsewhere.

    lost: about which share of the marks fails, 0 to 1.
    """

    called: str
    beyond: NDArray[np.bool_]
    lost: float


def rounded_everywhere(mesh: Mesh, found: Examination) -> Rounded | None:
    """Return the rounding of all coordinates that explains why marks fail; None where it does not.

    It does where it is coarser than what the marks were made for, and where marks fail everywhere alike. An edit is
    no less told by this: around it no mark holds, and such places are `beyond` what rounding explains.
    """
    error = found.checks.step / UNIT
    coarse = coarse_digits(mesh.vertices)
    if not found.marked or coarse is None or coarse.half <= error:
        return None
    if found.checks.torn.any() or found.points_missing:
        return None
    able, passed = found.checks.eligible, found.checks.passed
    rows = np.flatnonzero(able)
    held = float(passed[rows].mean()) if len(rows) else 0.0
    if held < _HOLD * _MARKS or len(rows) < 2 * _NEAR:
        return None
    points = found.surface.points
    near = np.asarray(KDTree(points[rows]).query(points[rows], k=_NEAR)[1])
    count = passed[rows][near].sum(axis=1)
    few = binom.cdf(count, _NEAR, held) < _CHANCE / len(rows)
    beyond = np.zeros(len(points), bool)
    beyond[rows[near[few].ravel()]] = True
    beyond &= found.altered
    return Rounded(coarse.called, beyond, max(0.0, 1.0 - held / _MARKS))

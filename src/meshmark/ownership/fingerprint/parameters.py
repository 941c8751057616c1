"""The numbers of the fingerprint, each with its reason, on one screen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.points.parameters import STEPS
from meshmark.ownership.points.point_choice import Choice

__all__ = [
    "CHOICES",
    "CLEAR",
    "COHERENT",
    "CONTRADICTED",
    "FAR",
    "FEWEST_PILOTS",
    "LARGEST_SHARE",
    "LEAST_POINTS",
    "LOCKED",
    "NAMED",
    "NEAR",
    "PILOTS",
    "RESERVED",
    "SHIFTS",
    "SURE_DEVIATIONS",
    "WITNESSES",
    "Reach",
    "choice_of",
]

# Every copy of a model has the same step, whatever its id: averages are read by it. Canonical units; on the grid of
# `points.parameters.STEPS`. The larger one moves points by 0.012 % of the diagonal, RMS, which "subtle" has no room
# for.
_STEPS: Final = {"subtle": float(STEPS[0]), "standard": float(STEPS[6]), "strong": float(STEPS[6])}
CHOICES: Final = tuple(Choice(step=step, mode=0, share=1.0) for step in sorted(set(_STEPS.values())))
# Models of at least this number of points: they have some thousands of coordinates.
LEAST_POINTS: Final = 5_000
# Shares of the coordinates: pilots carry 0 whatever the id; witnesses carry a hash of the id, which is no linear
# code.
PILOTS: Final = 0.15
WITNESSES: Final = 0.25
# RMS displacement that the cells leave to the fingerprint, over the budget; and of `LARGEST` the share.
RESERVED: Final = 0.25
LARGEST_SHARE: Final = 0.3
# Fewer pilots are not read. Places of each axis that are tried, to a step.
FEWEST_PILOTS: Final = 60
SHIFTS: Final = 16
# A lock less likely than 10^this, over all that was tried, is one; so is a word that is named, of eight at most
# that are looked for.
LOCKED: Final = -9.0
NAMED: Final = -9.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Reach:
    """Where a lock is looked for.

    expected: (4,) standard deviations of what is left to find of shift and logarithm of scale, in steps; turned: of
    the turn, in radians; deviations: how many of these are searched; places: of the grid, at most. peaks: that are
    polished; judges: pilots that they are judged by.
    """

    expected: FloatArray
    turned: float
    deviations: float
    places: int
    peaks: int
    judges: int


# At first, and then: the least or largest coordinates of copies have another shape.
_NEARBY: Final = Reach(
    expected=np.array([0.15, 0.15, 0.15, 0.5]),
    turned=1e-3,
    deviations=2.5,
    places=300_000,
    peaks=6,
    judges=500,
)
NEAR: Final = (_NEARBY, replace(_NEARBY, peaks=1, judges=2000))
# Of three and five copies they are turned by up to 4 milliradians. It is tried where pilots agree place by place by
# this number of standard deviations of chance (16 wrong locks had 3.1 at most, those of copies 5.5 to 32), and none
# lock nearby with a mean cosine as high as this, which one copy has, and the average of two.
FAR: Final = Reach(
    expected=np.array([0.3, 0.3, 0.3, 0.5]),
    turned=4e-3,
    deviations=2.0,
    places=2_000_000,
    peaks=6,
    judges=800,
)
COHERENT: Final = 3.5
CLEAR: Final = 0.6
# Witnesses are asked where they should stand out by this number of standard deviations of chance; an id of which
# they say less than this share of it is not that of a copy.
SURE_DEVIATIONS: Final = 6.0
CONTRADICTED: Final = 0.5


def choice_of(strength: str) -> Choice:
    """Return how the points of a model marked with this strength carry its fingerprint."""
    return Choice(step=_STEPS[strength], mode=0, share=1.0)

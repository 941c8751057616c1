"""The numbers of the authentication layer's marks, each with its reason, on one screen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, sqrt
from typing import Final

__all__ = [
    "ALTERNATIVES",
    "AMBIGUOUS",
    "COVERING",
    "FAR_AWAY",
    "FINE",
    "HASH_STEP",
    "HASH_STEPS",
    "LEVELS",
    "MARKED_LOG10",
    "PSNR_LEAST",
    "PSNR_WANTED",
    "REACH",
    "SMALL",
    "SMALL_RINGS",
    "SPARSEST",
    "SPREAD",
    "STYLES",
    "SWAY",
    "TRIED_IDS",
    "WAYS",
    "WEB",
    "WEB_GRID",
    "Layout",
    "Style",
]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """How the word of a mark is laid out.

    bits: of the word; check: of these, the MAC; symbol: the rest. rise: values of the coordinate along the ring's
    normal, which is seen most; 0: as many as of the other two. radix: values of each of the three coordinates;
    levels: most of them. window: marks may be this number of times as far off as their median. pieces_only: every
    mark carries a piece of the model's id, none its place or payload.
    """

    bits: int
    check: int
    rise: int = 0
    window: float = 8.0
    pieces_only: bool = False

    @property
    def symbol(self) -> int:
        """Return the bits that are not the MAC's."""
        return self.bits - self.check

    @property
    def levels(self) -> int:
        """Return the smallest number, of coordinates in the plane, with which there is room for the words."""
        if not self.rise:
            return ceil(float(2.0 ** (self.bits / 3.0)) - 1e-9)
        return ceil(sqrt(2.0**self.bits / self.rise) - 1e-9)

    @property
    def radix(self) -> tuple[int, int, int]:
        """Return how many values each coordinate has."""
        return self.levels, self.levels, self.rise or self.levels


@dataclass(frozen=True, eq=False, kw_only=True)
class Style:
    """One of the ways in which marks are made; a reader tries all.

    pull: the place of a mark is the point less a +-1 sum of its ring, else less the ring's mean: then errors grow
    a third as much, and so does what a neighbour that was moved does to it. unit: the smallest step, in units of
    the largest error of a coordinate. hash_least: fewest steps of a unit of the ring's lengths. tolerance: number
    of steps over the ring's spread by which a length may be off. layouts: by their bits, most first. least: fewest
    marks.
    """

    pull: bool
    unit: float
    hash_least: float
    tolerance: float
    layouts: tuple[Layout, ...]
    least: int


# Step of a ring in units of its size: 2^(-level / 2), which keeps the step in scene units within a factor 1.42.
LEVELS: Final = range(8, 39)
# Marks move at most half of this, in ring sizes, along each axis.
REACH: Final = 0.6
# Largest growth of an error in a ring that may carry a mark (`RingShapes.spread`): beyond are slivers.
SPREAD: Final = 5.0
# A mark at the end of its reach moves by at most this share of a step (standard deviation) as errors turn the frame
# of its ring; half a step is more than four of the deviations that the step is made for, 0.12 each.
SWAY: Final = 0.05
# A mark that errors of its ring swing so many times as far as others may be read after one rounding, but not after
# another that changes as much; of its place no more is believed.
UNREADABLE: Final = 2.0
# The error of 32-bit floats, over the diagonal, when the model lies six diagonals from the origin: scaled down to a
# seventh and moved away by one diagonal of before.
FAR_AWAY: Final = 4.5e-7
# Half the step of a grid of 14 bits, over the longest side.
WEB_GRID: Final = 2.0**-15
# The ring's hash takes its lengths in units of HASH_STEPS steps, but of no more than HASH_STEP ring sizes, unless
# the style's least number of steps is more: in the rings of a subdivided surface four lengths each are alike, near
# a boundary all at once.
HASH_STEPS: Final = 32.0
HASH_STEP: Final = 1.0 / 16.0
# Most lengths of a ring that may be near a rounding boundary, and most neighbours that may be the farthest.
AMBIGUOUS: Final = 3
ALTERNATIVES: Final = 8
# PSNR of this layer alone, in dB: bits are given up to reach the one; without the other there is no mark.
PSNR_WANTED: Final = 80.2
PSNR_LEAST: Final = 70.0
# Share of the rings with room for a mark of the fewest bits that must have room for one of more.
COVERING: Final = 0.95

_SIGMA: Final = 1.0 / sqrt(3.0)
# Half a step is 4.3 standard deviations of the error of the mark's place, as the spread predicts it; measured on
# the training models it is 0.7 of that at most, so half a step is 5.7 deviations. 6 bits of MAC let one altered
# mark in 64 through, fewer where marks lie near their whole places (`checks`); room above 10 bits of symbol goes to
# the MAC. A length is off by the error of two points, not of a ring.
FINE: Final = Style(
    pull=True,
    unit=2.0 * 4.3 * _SIGMA,
    hash_least=6.0,
    tolerance=1.0,
    layouts=tuple(
        Layout(bits=bits, check=check)
        for bits, check in {18: 8, 17: 7, 16: 6, 15: 6, 14: 6, 13: 6, 12: 6, 11: 6, 10: 6}.items()
    ),
    least=40,  # fewer do not carry the model's id
)
# Marks of small models, whose id the layer below tells: most of the word is MAC, so that few are evidence enough.
SMALL: Final = replace(
    FINE,
    layouts=tuple(
        Layout(bits=layout.bits, check=layout.bits - 4, pieces_only=True) for layout in FINE.layouts
    ),
    least=6,
)
# Such marks are made and looked for where at most this number of points have rings.
SMALL_RINGS: Final = 1_000
# Marks that bear a grid of 14 bits: as small as such an error lets them be (docs/decisions/0023-tolerance-web.md).
WEB: Final = Style(
    pull=False,
    unit=2.0 * 2.7 * _SIGMA,
    hash_least=10.0,
    tolerance=0.55,
    layouts=(
        Layout(bits=10, check=6, rise=4, window=2.0),
        Layout(bits=9, check=5, rise=4, window=2.0),
    ),
    least=40,
)
STYLES: Final = (FINE, WEB, SMALL)
# Ids that are tried where some of their pieces are in doubt: all 16 values of one of 4 bits, two of another.
TRIED_IDS: Final = 32
# Ways to read marks that are tried: ids, levels of the step and layouts.
WAYS: Final = TRIED_IDS * len(LEVELS) * sum(len(style.layouts) for style in STYLES)
# Readers find out how marks were made from a sample of 600 rings at least: of more rings than `SMALL_RINGS`, fewer
# marks than this share would not be found in it.
SPARSEST: Final = 0.01
# Marks are there where the chance of as many without the key is below 10 to this.
MARKED_LOG10: Final = -9.0

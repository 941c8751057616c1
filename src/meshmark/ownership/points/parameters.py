"""The numbers of the carriers at points, each with its reason, on one screen."""

from __future__ import annotations

from typing import Final

import numpy as np

__all__ = [
    "DEAREST_LABEL",
    "DISTINCT_BITS",
    "FEW_POINTS",
    "FREE",
    "GUARD",
    "KEPT_SHARE",
    "LARGEST",
    "LIFTED",
    "MODES",
    "MOMENTS_APART",
    "MOST_POINTS",
    "MOST_UNSMOOTHED",
    "READABLE",
    "ROOM",
    "SHARES",
    "SIDE",
    "SLIDING",
    "STEPS",
    "SURELY_SKEW",
    "TIES",
]

# Side of the cubes that name the points, in units of the canonical scale: small enough that most points of a coarse
# model have one of their own.
SIDE: Final = 0.06
# Quantisation steps, in units of the canonical scale.
STEPS: Final = 0.0004 * 2.0 ** (np.arange(20) / 4.0)
# How many coordinates a point carries on a plane, on a crease, and at a corner.
MODES: Final = ((2, 1, 0), (2, 1, 1), (2, 2, 2), (3, 3, 3))
# Of the last mode, this share of the coordinates is used: nothing else would be left that holds the frame.
KEPT_SHARE: Final = 0.85
# Shares of the coordinates that carry, drawn by the key: fewer, moved further, bear more noise.
SHARES: Final = (1.0, 0.5, 0.25, 0.125, 0.0625)
# With fewer code bits no id of so many bits is read back: those, and what the hypotheses of an extraction take.
DISTINCT_BITS: Final = {64: 88, 32: 56, 0: 14}
# Of surfaces with fewer points than this, which cannot carry 64 bits, as few coordinates are read as this, else 40.
FEW_POINTS: Final = 30
READABLE: Final = (10, 40)
# An eigenvalue of the star below this is a direction along the surface.
FREE: Final = 0.02
# Cost of moving along the surface, over that of leaving all the planes of a star.
SLIDING: Final = 0.003
# What coordinates count when those of a point are chosen, from the one that the key prefers on: settles the ties of
# boxes, not all one way, or all corners of a side would bend it.
TIES: Final = np.array([1.0, 0.8, 0.62])
# A point carries only where the triangles of its star are this many steps high.
ROOM: Final = 2.0
# A set point stays this many steps inside its cube.
GUARD: Final = 0.25
# Largest displacement of a point over the diagonal of the bounding box.
LARGEST: Final = {"subtle": 5e-4, "standard": 1.5e-3, "strong": 4e-3}
# Larger models are neither marked at points nor searched for it: their triangles are short enough for cells.
MOST_POINTS: Final = 100_000
# Points of larger models are not read in all shapes from which they may have been smoothed: they rarely carry, and
# each shape takes as long as the surface.
MOST_UNSMOOTHED: Final = 5_000
# A face whose normal turns by more than this cosine was folded over: its points stay where they are.
LIFTED: Final = 0.7
# Second moments, shares of their sum, are kept this far apart, or this many RMS budgets times the width of the
# model along the two axes (all in canonical units), whichever is less.
MOMENTS_APART: Final = (0.0015, 1.2)
# Damage that marks at points bear moves no coordinate of the label by more than a thirtieth of a bin, and turns no
# axis round that is more skew than this (decision 0044): a search, unless it is wide, leaves out labels of a higher
# price, in squared widths of a bin, and such turns.
DEAREST_LABEL: Final = 0.001
SURELY_SKEW: Final = 0.005

"""The numbers of the ownership layer, each with its reason, on one screen."""

from __future__ import annotations

from typing import Final

import numpy as np

__all__ = [
    "ACCUSED_LOG10",
    "ALIKE",
    "BUDGET_SHARE",
    "CARRIER_ENOUGH",
    "CARRIER_GOAL",
    "CARRIER_MINIMUM",
    "CARRIER_MOST",
    "CARRIER_PLENTY",
    "CARRIER_READABLE",
    "CREDIBLE_LOG10",
    "CROP_APART",
    "CROP_CARRIERS",
    "CROP_EXPECTED",
    "CROP_FRAMES",
    "CROP_LABELS",
    "CROP_SPACINGS",
    "DEAREST_LABEL",
    "DEAREST_UNDONE",
    "DECODE_LOG10",
    "DIVERGED",
    "EMBED_SELECTION",
    "EXTRACT_SELECTION",
    "FURTHER_SHARE",
    "GATHER",
    "HOPELESS_BITS",
    "HOPELESS_ERROR",
    "LABELS",
    "LOCK_CANDIDATES",
    "LOCK_EXPECTED",
    "LOCK_PEAKS",
    "LOCK_POLISHED",
    "LOCK_RADIUS",
    "LOCK_STEPS",
    "LOCK_TURNS",
    "LONGEST_EDGES",
    "LONGEST_SAMPLE",
    "LONG_EDGES",
    "LOST_ERROR",
    "LOW_PASSED_EDGES",
    "MOMENT_GAP",
    "NEEDED_BITS",
    "ORIGINAL_SPACINGS",
    "PRESENCE_LOG10",
    "PRESENT_LOG10",
    "PROVEN_LOG10",
    "RESTORED_LOG10",
    "SOLVE_PASSES",
    "SOLVE_TOLERANCE",
    "SPACINGS",
    "SPACING_ORDER",
    "SPACING_TRIES",
    "STEPS",
    "STEP_TRIES",
    "SURELY_SKEW",
    "TYPICAL_LOUDNESS",
    "TYPICAL_NOISE",
    "TYPICAL_STEP",
    "preferred_spacings",
]

# Plan for a little less than the budget: the solve adds a few per cent while it converges.
BUDGET_SHARE: Final = 0.95

# Lattice spacings in units of the canonical scale. A fixed grid, because extraction must hit the very same one.
SPACINGS: Final = 0.5 * 2.0 ** (-np.arange(19) / 4.0)
# Wanted number of cells, with a patch of area spacing^2 each; fewer carry more energy per bit, more carry more
# bits.
CARRIER_GOAL: Final = 300
# A spacing with this many carriers is taken; else the one with most.
CARRIER_ENOUGH: Final = 230
# An extraction that reads at least this number takes the spacing for such a one: more, as an attack may have lost
# or added some.
CARRIER_PLENTY: Final = 240
# With fewer carriers of an id of so many bits no decoder can distinguish it from chance (decisions 0004, 0033).
CARRIER_MINIMUM: Final = {64: 110, 32: 75, 0: 60}
# Nor is it tried where the cells that are read yield fewer bits than this by hard decisions (64 are needed): of the
# lattices of small training models those that could be read yielded 64 and more, and none of eleven below 50. Fewer
# bits need fewer.
HOPELESS_BITS: Final = {64: 50.0, 32: 25.0, 0: 8.0}
# Fewer carriers than this are not read at all: nothing could be decided from them.
CARRIER_READABLE: Final = 60
# Nor are more than these: no embedding takes a spacing so fine, and what looks at pairs of cells would not fit.
CARRIER_MOST: Final = 3000
# Spacings tried around the preferred one, nearest first; thin walls need finer ones.
SPACING_ORDER: Final = (0, 1, 2, 3, -1, 4, 5, -2)

# Number of spacings with carriers enough that an embedding tries, before those with fewer carriers.
SPACING_TRIES: Final = 3

# Where the triangles are longer than this, in spacings, mean over the surface, an embedding tries one spacing only,
# or no cells at all: of 36 small training models none above 3.7 carried an id in its cells, and above 2.5 points
# bear as much (decision 0024). Above the last no cells are read: models of 5,000 points and more stay below it when
# they are simplified to a twentieth.
LONG_EDGES: Final = (1.5, 2.5)
LONGEST_EDGES: Final = 3.2

# Above this the mildest filter of a restoration leaves less than a third of waves two spacings long, and so of the
# mark: only the shape as it stands is corrected there, unless the search is wide (decision 0044).
LOW_PASSED_EDGES: Final = 1.1

# Quantisation steps in spacings. Above the largest, bumps become visible and the solve nonlinear.
STEPS: Final = 0.24 * 2.0 ** (-np.arange(13) / 2.0)

# The step is chosen that bears most noise, or, of those that bear this standard deviation along normals, over the
# diagonal, the one that tells most under it.
TYPICAL_NOISE: Final = 0.0012
# Bits that the cells must yield by their cosines, n a^2 / ln 2 with a their mean, so that an id is read.
NEEDED_BITS: Final = 100.0
# The search for the step begins where the mark without compensation would be seen so much (95th percentile).
TYPICAL_LOUDNESS: Final = 1.5

# Number of steps that an embedding tries, from the one that tells most down.
STEP_TRIES: Final = 3

# A sample of the surface is no longer than this share of a spacing (quadrature error below 0.003 spacings).
LONGEST_SAMPLE: Final = 0.25

# Samples of a suspect's shapes are gathered in cubes whose edge is this number of longest samples.
GATHER: Final = 0.7

# (mass, flatness, largest |offset|): the embedder shapes every cell that the extractor might select.
EXTRACT_SELECTION: Final = (0.35, 0.70, 0.50)
EMBED_SELECTION: Final = (0.28, 0.60, 0.60)

# Second moments along different axes are kept apart by this share of their sum, so that the axes are defined.
MOMENT_GAP: Final = 1e-3

# A lock less likely than 10^this by chance is worth decoding.
DECODE_LOG10: Final = -3.0
# Nor is one of a restoration that does not stand out from the best of the corrections that were tried: without a
# mark one in six is less likely than this, and none above told an id that no other did (decision 0044).
RESTORED_LOG10: Final = -6.5
# Axes whose moments differ by less than this turn so easily that they are held instead of followed.
ALIKE: Final = 0.02
# Newton passes at most, and the largest error, in steps, with which they may stop.
SOLVE_PASSES: Final = 10
SOLVE_TOLERANCE: Final = 0.03
# A pass with this number of times the best error so far is the last.
DIVERGED: Final = 2.0
# After three passes, a mean error of this many steps will not come down far enough any more.
HOPELESS_ERROR: Final = 0.12
# A cell further than this from its target, in steps, says nothing any more: a larger error is no worse.
LOST_ERROR: Final = 0.25

# Of the correction of a frame: standard deviation of shift (3), logarithm of scale, turn (3, radians), and how many
# of these the search reaches out. Restored shapes under the attacks of docs/design.md, section 10, drift by 0.001
# to 0.01.
LOCK_EXPECTED: Final = np.array([0.005] * 4 + [0.006] * 3)
LOCK_RADIUS: Final = 3.0
# Steps that a search tries: those that embeddings of any strength use.
LOCK_STEPS: Final = tuple(float(step) for step in STEPS[:8])
# A step such as standard marks have: clusters of cells are chosen by it.
TYPICAL_STEP: Final = 0.1
# Number of peaks of the lock that are looked at for each step, of those that are polished of all steps (that which
# told an id was among the best ten; decision 0044), and of corrections of a reading that are decoded.
LOCK_PEAKS: Final = 6
LOCK_POLISHED: Final = 16
LOCK_CANDIDATES: Final = 5
# A lock less likely than 10^this by chance, over its own search, is worth measuring anew where it puts the model.
CREDIBLE_LOG10: Final = -0.5
# Frames that a cropped model may have had with what is gone, so far apart (RMS motion over scale); the standard
# deviation of what is left to find of each part of the correction.
CROP_APART: Final = 0.035
CROP_EXPECTED: Final = np.array([0.014] * 3 + [0.011] + [0.016] * 3)
# Number of these frames that are tried, and of the labels of each: of 210 crops no id was told by the seventh or a
# later one, nor by a fourth label (decision 0048).
CROP_FRAMES: Final = {"quick": 6, "wide": 60}
CROP_LABELS: Final = {"quick": 3, "wide": 6}
# Spacings with at least this number of carriers left may be that of the whole; the first few are tried.
CROP_CARRIERS: Final = 130
CROP_SPACINGS: Final = 2
# Number of spacings that are read in each frame that an original gives.
ORIGINAL_SPACINGS: Final = 3
# Most labels of the lattice that are tried for each shape that a suspect may have had, and the highest price of any
# but the first: of a shape as it stands, and of one from which smoothing or a crop was taken back (decision 0020).
LABELS: Final = {"plain": 2, "quick": 6, "wide": 8}
DEAREST_LABEL: Final = 0.01
DEAREST_UNDONE: Final = 0.02
# Number of turns of a frame that a quick search goes through.
LOCK_TURNS: Final = 2
# An axis more skew than this is not turned round by an attack.
SURELY_SKEW: Final = 0.03

# "present" needs a false-positive bound below 10^this over everything that was tried.
PRESENT_LOG10: Final = -6.0
# Where the lock is credible, an id is named if its word agrees so well by chance only (decision 0004): a tenth of
# the bound above, as several readings of one mark are decoded.
PROVEN_LOG10: Final = -7.0
ACCUSED_LOG10: Final = -6.0
"""A listed id is named where the chance is below 10^this that a copy with none of them tells one of them."""
# Where the lock is credible, the words of ids of 32 bits and that of the mark without an id are looked for, too,
# each at this share of what chance may do; and the latter is named where its word agrees so well by chance only
# (decision 0033).
FURTHER_SHARE: Final = 0.01
PRESENCE_LOG10: Final = -3.0


def preferred_spacings(area: float) -> list[float]:
    """Spacings to try for a surface of this canonical area, likeliest first."""
    best = int(np.argmin(np.abs(np.log(SPACINGS) - 0.5 * np.log(area / CARRIER_GOAL))))
    indices = [best + turn for turn in SPACING_ORDER]
    return [float(SPACINGS[i]) for i in indices if 0 <= i < len(SPACINGS)]

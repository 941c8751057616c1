"""Colours of what an authentication says: of altered places, of conditions, and of regions by failed checks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray
from meshmark.report.colours import lit_heat, oklch
from meshmark.report.picture import CLAY

if TYPE_CHECKING:
    from meshmark.authentication.regions.region import Region

__all__ = ["CONDITION_COLOURS", "altered_colours", "failed_colours", "in_order", "region_shades"]

RED = np.array([0.62, 0.012, 0.012])
"""Linear RGB of what is altered."""
CONDITION_COLOURS: Final = {
    "intact": ("Intact", "#dbd9d4"),
    "altered": ("Altered", "#b3123a"),
    "moved": ("Moved as one, or pasted; its inside intact", "#2b6cb8"),
    "cut_off": ("Intact, but cut off by what was altered: it may have moved with it", "#86bbea"),
    "unchecked": ("Not checked", "#a9adb3"),
}
"""Of `CONDITIONS`: what the legend says, and sRGB; reds and blues that differ in lightness, too."""


def altered_colours(altered: NDArray[np.bool_]) -> FloatArray:
    """Return (n, 3) linear RGB: red for what is altered, clay for the rest."""
    return np.where(altered[:, None], RED, CLAY)


def failed_colours(share: FloatArray) -> FloatArray:
    """Return (n, 3) linear RGB for shares of failed checks (n,), 0 to 1; grey where there is none (NaN)."""
    known = np.isfinite(share)
    shade = lit_heat(np.where(known, share, 0.0))
    return np.where(known[:, None], shade, np.array([0.40, 0.42, 0.45]))


def in_order(regions: Sequence[Region]) -> list[Region]:
    """Return regions for a table: the altered ones first, those with most failed checks before the others."""
    return sorted(regions, key=lambda region: (region.verdict != "altered", -region.failed, region.id))


def region_shades(regions: Sequence[Region]) -> FloatArray:
    """Return (k, 3) linear RGB: the heat of each region's share of failed checks, on a scale of square roots.

    Regions without checks are grey. Neighbours in the list differ a little in lightness, so that borders show.
    """
    checks = np.array([region.checks for region in regions], float)
    failed = np.array([region.failed for region in regions], float)
    share = np.divide(failed, checks, out=np.zeros(len(regions)), where=checks > 0.0)
    shade = lit_heat(np.sqrt(np.minimum(share, 1.0)))
    step = np.arange(len(regions)) % 3
    grey = oklch(0.72 + 0.05 * step, 0.01, np.full(len(regions), 250.0))
    lighter = 1.0 - 0.09 * step
    return np.where(checks[:, None] > 0.0, shade * lighter[:, None], grey)

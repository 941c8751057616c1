"""Members of groups that lie one after another in a flat list."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import IntArray

__all__ = ["members"]


def members(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return, for groups of the given sizes (g,), each member's group and its place within the group."""
    group = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(group)) - np.repeat(np.cumsum(counts) - counts, counts)
    return group, place

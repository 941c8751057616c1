"""From checks to a map: which points were altered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.checks import Checks
from meshmark.geometry.components import connected_parts
from meshmark.geometry.open_edges import open_edges
from meshmark.geometry.surface import Surface

__all__ = ["altered_points"]

# A point on the border of an altered part with this share of neighbours that are vouched for was not altered
# itself.
_VOUCHED = 0.55
# In a requantised file up to this number of failing points that hang together are rounding's: a mark that it broke
# leaves mostly one, at most three without a voucher.
_ROUNDING = 4


def altered_points(surface: Surface, checks: Checks) -> NDArray[np.bool_]:
    """Return (p,): the points that an edit seems to have moved, made, or laid bare.

    A point without a mark that holds next to it is altered, but for the border of a larger altered part: marks
    there fail for the sake of one neighbour, and leave intact ones without a voucher (not so where the surface
    ends). In a requantised file rounding breaks single marks, so few points together are not altered. Points whose
    rings carry no marks are judged as the nearest that do, an altered one before an intact one.
    """
    count, graph = len(surface.points), surface.graph
    suspect = checks.eligible & ~checks.verified
    degree = np.maximum(graph @ (checks.eligible | checks.verified).astype(np.float64), 1.0)
    inner = suspect & ((graph @ checks.verified.astype(np.float64)) / degree < _VOUCHED)
    start, end, _ = open_edges(surface.faces, count)
    inner[start] = suspect[start]
    inner[end] = suspect[end]
    border = suspect & ~inner & (graph @ inner.astype(np.float64) > 0.0)
    altered = suspect & ~border
    if checks.requantised:
        altered &= ~_few_together(surface, altered) | checks.new_boundary
    open_ = ~checks.eligible & ~checks.verified
    known = ~open_
    while open_.any():
        near_altered = graph @ altered.astype(np.float64) > 0.0
        reached = open_ & (near_altered | (graph @ known.astype(np.float64) > 0.0))
        if not reached.any():
            break
        altered |= reached & near_altered
        known |= reached
        open_ &= ~reached
    return np.asarray(altered)


def _few_together(surface: Surface, altered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): the altered points that hang together with at most `_ROUNDING` in all."""
    part = connected_parts(surface.graph, altered)
    size = np.bincount(part[altered], minlength=1)
    return np.asarray(altered & (size[part] <= _ROUNDING))

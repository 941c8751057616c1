"""Places of a model in words, as the pictures of a report show it: "top left"."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.view import Stance, three_quarter_view
from meshmark.mesh import FloatArray

__all__ = ["region_labels"]

_HEIGHTS = ("bottom", "middle", "top")
_SIDES = ("left", "", "right")


def region_labels(points: FloatArray, places: FloatArray, stance: Stance | None = None) -> list[str]:
    """Return the words for each of `places` (k, 3) in a model with `points` (p, 3).

    The model is looked at as pictures show it and its box is cut in thirds; what lies in the back is said so.
    stance: how it stands, where its file says so.
    """
    view = three_quarter_view(points, stance)
    seen = points @ view.T
    low, size = seen.min(axis=0), np.maximum(np.ptp(seen, axis=0), 1e-300)
    thirds = np.clip((3.0 * (places @ view.T - low) / size).astype(int), 0, 2)
    return [_words(side, height, depth) for side, height, depth in thirds]


def _words(side: int, height: int, depth: int) -> str:
    parts = [_HEIGHTS[height], _SIDES[side], "back" if depth == 0 else ""]
    if height == 1 and (side != 1 or depth == 0):
        parts = parts[1:]
    return " ".join(part for part in parts if part)

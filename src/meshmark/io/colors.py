"""Vertex colours as files write them: 0 to 255 or 0 to 1, with or without opacity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["ODD_COLORS", "rgba", "to_linear"]

# How a report names colours that are lost because they are no colours.
ODD_COLORS = "vertex colours, some of which are not finite numbers"


def rgba(numbers: FloatArray, unit: bool | None = None) -> NDArray[np.uint8]:
    """Return (n, 4) RGBA bytes of (n, 3) or (n, 4) colours; values out of range are clipped.

    unit: whether 1 is full intensity; None: decided by whether all numbers lie in 0 to 1.
    """
    if unit is None:
        unit = bool((numbers <= 1).all())
    scaled = np.clip(np.rint(numbers * 255 if unit else numbers), 0, 255).astype(np.uint8)
    full = np.full((len(numbers), 4), 255, dtype=np.uint8)
    full[:, : scaled.shape[1]] = scaled
    return full


def to_linear(srgb: FloatArray) -> FloatArray:
    """Return linear light for sRGB values in [0, 1] (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)

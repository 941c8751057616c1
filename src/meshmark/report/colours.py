"""Colours that differ as much to the eye as in number: OKLCh ramps and palettes, as linear RGB."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshmark.io.colors import to_linear
from meshmark.mesh import FloatArray, IntArray

__all__ = ["heat", "hex_colours", "lit_heat", "oklch", "palette", "region_colours", "to_linear", "to_srgb"]

# OKLab to cube roots of cone responses, and cone responses to linear sRGB (B. Ottosson, 2020).
_CONES = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def oklch(lightness: ArrayLike, chroma: ArrayLike, hue_degrees: ArrayLike) -> FloatArray:
    """Return (..., 3) linear RGB in [0, 1] for OKLCh colours; what lies outside is clipped."""
    angle = np.deg2rad(np.asarray(hue_degrees, float))
    strength = np.asarray(chroma, float)
    lab = np.broadcast_arrays(
        np.asarray(lightness, float), strength * np.cos(angle), strength * np.sin(angle)
    )
    linear: FloatArray = (np.stack(lab, axis=-1) @ _CONES.T) ** 3 @ _RGB.T
    return np.clip(linear, 0.0, 1.0)


def heat(values: FloatArray) -> FloatArray:
    """Return (..., 3) linear RGB for values in [0, 1]: white, amber, red, plum; lightness falls evenly."""
    t = np.clip(values, 0.0, 1.0)
    return oklch(0.95 - 0.58 * t, 0.012 + 0.20 * np.sqrt(t) * (1.0 - 0.25 * t), 95.0 - 110.0 * t)


def lit_heat(values: FloatArray) -> FloatArray:
    """Return `heat` up to red, for values in [0, 1] on surfaces whose shading is to be seen in the darkest
    colour."""
    return heat(0.82 * np.clip(values, 0.0, 1.0))


def palette(count: int) -> FloatArray:
    """Return (count, 3) linear RGB of similar lightness, hues by the golden angle on three levels."""
    at = np.arange(count)
    return oklch(0.66 + 0.11 * (at % 3), 0.125, 30.0 + 137.50776 * at)


def region_colours(region: IntArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count, 3): a colour for each region, far from its neighbours' and seldom used before."""
    shades = palette(max(24, count))
    gap = np.linalg.norm(np.cbrt(shades)[:, None] - np.cbrt(shades)[None], axis=2)
    touching = _touching(region, faces, count)
    chosen = np.full(count, -1)
    used = np.zeros(len(shades))
    for i in range(count):
        near = chosen[touching[i] & (chosen >= 0)]
        worth = gap[:, near].min(axis=1, initial=0.6) - 0.25 * used
        chosen[i] = int(worth.argmax())
        used[chosen[i]] += 1.0
    colours: FloatArray = shades[chosen]
    return colours


def _touching(region: IntArray, faces: IntArray, count: int) -> NDArray[np.bool_]:
    touching = np.zeros((count, count), bool)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        touching[region[faces[:, i]], region[faces[:, j]]] = True
    return touching | touching.T


def to_srgb(linear: NDArray[np.floating[Any]]) -> NDArray[np.uint8]:
    """Return sRGB bytes for linear light in [0, 1]."""
    steps = np.linspace(0.0, 1.0, 4096)
    curve = np.where(steps <= 0.0031308, 12.92 * steps, 1.055 * steps ** (1 / 2.4) - 0.055)
    table = np.round(255.0 * curve).astype(np.uint8)
    picture: NDArray[np.uint8] = table.take((np.clip(linear, 0.0, 1.0) * 4095.0 + 0.5).astype(np.int32))
    return picture


def hex_colours(linear: FloatArray) -> list[str]:
    """Return "#rrggbb" for each of (k, 3) linear RGB colours."""
    return ["#" + bytes(row).hex() for row in to_srgb(linear)]

"""The layers of an interactive view: what the colours of a surface tell, with the legend that explains them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray
from meshmark.report.colours import hex_colours, lit_heat
from meshmark.report.picture import Panel

__all__ = ["NO_VALUE", "Layer", "category_layer", "heat_layer", "surface_layer"]

NO_VALUE = "#a9adb3"
"""Grey of what has no value."""
_SHADES = 24
_TOP = 254
"""Largest value of a heat layer; the next number says that there is none."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Layer:
    """One layer of a view of n vertices.

    name: by which scripts choose it; title: for the reader. kind: "surface", "categories" or "heat". values: (n, 3)
    uint8 sRGB, (n,) uint16 places in legend["entries"], or (n,) uint8 from 0 (first of legend["colours"]) to 254
    (last), 255 for none; None for a surface without colours of its own. legend: what the viewer draws, as JSON.
    unit: above the scale, what its numbers are. note: a sentence below the legend. own: of a surface with paint,
    shown instead of the values where the view has all of its triangles.
    """

    name: str
    title: str
    kind: str
    values: NDArray[np.uint8] | NDArray[np.uint16] | None
    legend: dict[str, Any] | None = None
    unit: str = ""
    note: str = ""
    own: Panel | None = None


def surface_layer(colours: NDArray[np.uint8] | None, *, note: str = "", own: Panel | None = None) -> Layer:
    """Return the layer of the surface as it is.

    colours: (n, 3) sRGB of its vertices, None for plain clay. note, own: see `Layer`.
    """
    return Layer(name="surface", title="Surface", kind="surface", values=colours, note=note, own=own)


def heat_layer(
    name: str,
    title: str,
    shares: FloatArray,
    ticks: Sequence[tuple[float, str]],
    *,
    unit: str = "",
    missing: str = "",
    note: str = "",
) -> Layer:
    """Return a layer of values as colour, from nearly white to red.

    Parameters
    ----------
    name, title : str
    shares : (n,) float array
        Places on the scale of colours, 0 to 1; NaN where there is no value.
    ticks : sequence of (float, str)
        Numbers under the scale: the place, 0 to 1, and its label.
    unit, note : str
        See `Layer`.
    missing : str
        What it means that a vertex has no value; empty where all have one.

    Returns
    -------
    Layer
    """
    known = np.isfinite(shares)
    values = np.full(len(shares), _TOP + 1, np.uint8)
    values[known] = np.round(np.clip(shares[known], 0.0, 1.0) * _TOP).astype(np.uint8)
    legend = _scale(ticks)
    if missing:
        legend["missing"] = {"label": missing, "colour": NO_VALUE}
    return Layer(name=name, title=title, kind="heat", values=values, legend=legend, unit=unit, note=note)


def category_layer(
    name: str,
    title: str,
    category: IntArray,
    entries: Sequence[tuple[str, str]],
    *,
    ticks: Sequence[tuple[float, str]] = (),
    unit: str = "",
    note: str = "",
) -> Layer:
    """Return a layer of categories.

    category: (n,) places in `entries`, each a label (empty: not in the legend) and a colour, "#rrggbb". ticks,
    unit: of a scale like that of `heat_layer`, where the colours of the categories are taken from it.
    """
    legend: dict[str, Any] = {"entries": [{"label": label, "colour": colour} for label, colour in entries]}
    if ticks:
        legend |= _scale(ticks)
    values = category.astype(np.uint16)
    return Layer(
        name=name, title=title, kind="categories", values=values, legend=legend, unit=unit, note=note
    )


def _scale(ticks: Sequence[tuple[float, str]]) -> dict[str, Any]:
    """Return the scale of `lit_heat` as a legend."""
    return {
        "colours": hex_colours(lit_heat(np.linspace(0.0, 1.0, _SHADES))),
        "ticks": [{"at": at, "label": label} for at, label in ticks],
    }

"""An interactive view as JSON: a surface and its layers, which `createViewer` of the viewer takes."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.report.colours import to_srgb
from meshmark.report.view_layer import Layer
from meshmark.report.view_skin import fits, skin_of
from meshmark.report.view_surface import ViewSurface

__all__ = ["surface_view"]

_GRID = 65535
_TYPES = {"uint8": "u1", "uint16": "<u2", "uint32": "<u4"}


def surface_view(shown: ViewSurface, layers: Sequence[Layer], *, start: str, label: str) -> dict[str, Any]:
    """Return a view of a surface, ready for `json.dumps`.

    Parameters
    ----------
    shown : ViewSurface
        Of a file with n vertices.
    layers : sequence of Layer
        Their values in the order of the file's vertices.
    start : str
        Name of the layer that is shown first.
    label : str
        What the view shows, for who cannot see it.

    Returns
    -------
    dict
        vertices, faces (counts), positions (uint16 on a grid over `box`), triangles (uint32), layers, start, label,
        note. A painted surface has colours of corners, with `corners` true, and as `skin` its images. Arrays are
        {"type", "data"}: little-endian, in base64.
    """
    low, high = shown.points.min(axis=0), shown.points.max(axis=0)
    scale = (
        float((high - low).max()) or 1.0
    )  # the viewer's numbers are single: none is too large or too small
    grid = np.round((shown.points - low) / np.where(high > low, high - low, 1.0) * _GRID)
    return {
        "vertices": len(shown.points),
        "faces": len(shown.faces),
        "box": {"low": [0.0, 0.0, 0.0], "high": ((high - low) / scale).tolist()},
        "positions": _packed(grid, "uint16"),
        "triangles": _packed(shown.faces, "uint32"),
        "layers": [_layer(layer, shown) for layer in layers],
        "start": start,
        "label": label,
        "note": _note(shown),
    }


def _painted(layer: Layer, shown: ViewSurface) -> dict[str, Any] | None:
    """Return what of a layer is its paint, None where the view cannot show it: it has fewer triangles."""
    own = layer.own
    if own is None or own.paint is None or shown.shown_of is not None or not fits(own.paint):
        return None
    if len(own.paint.image) != len(shown.faces):
        return None
    colours = np.repeat(own.paint.factor.astype(np.float64)[:, None], 3, axis=1)
    if own.colours is not None:
        colours = colours * own.colours[own.faces]
    painted: dict[str, Any] = {"values": _packed(to_srgb(colours), "uint8"), "corners": True, "note": ""}
    if own.paint.images:
        skin = skin_of(own.paint)
        packed = {"image": _packed(skin["image"], "uint8"), "places": _packed(skin["places"], "uint16")}
        painted["skin"] = {**skin, **packed}
    return painted


def _layer(layer: Layer, shown: ViewSurface) -> dict[str, Any]:
    values = None
    if layer.values is not None:
        values = _packed(layer.values[shown.vertex], "uint16" if layer.kind == "categories" else "uint8")
    return {
        "name": layer.name,
        "title": layer.title,
        "kind": layer.kind,
        "values": values,
        "legend": layer.legend,
        "unit": layer.unit,
        "note": layer.note,
        **(_painted(layer, shown) or {}),
    }


def _packed(values: NDArray[Any], kind: str) -> dict[str, str]:
    data = np.ascontiguousarray(values).astype(_TYPES[kind]).tobytes()
    return {"type": kind, "data": base64.b64encode(data).decode("ascii")}


def _note(shown: ViewSurface) -> str:
    if shown.shown_of is None:
        return ""
    return f"The view shows {len(shown.faces):,} of {shown.shown_of:,} triangles."

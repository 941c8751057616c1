"""Layers that views of any report have: the surface in its own colours, and its saliency."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, Mesh
from meshmark.report.colours import lit_heat, to_srgb
from meshmark.report.own_colours import own_colours
from meshmark.report.view_layer import Layer, heat_layer, surface_layer

__all__ = ["ROOT_TICKS", "displacement_layer", "displacement_shades", "own_surface", "saliency_layer"]

ROOT_TICKS = tuple(
    (share**0.5, label) for share, label in ((0.0, "0"), (0.05, "0.05"), (0.3, "0.3"), (1.0, "1"))
)
"""Ticks of a scale of square roots."""

_AT_VERTICES = "Colours of textures are shown as they are at the vertices; still pictures show the textures."


def own_surface(mesh: Mesh) -> Layer:
    """Return the surface in the colours that its file has, else in clay."""
    own = own_colours(mesh)
    colours = own.at_vertices()
    shades = None if colours is None else to_srgb(colours)
    if own.paint is None:
        return surface_layer(shades)
    return surface_layer(shades, note=_AT_VERTICES if own.paint.images else "", own=own.panel(""))


def saliency_layer(mesh: Mesh) -> Layer:
    """Return how much each place stands out, on a scale of square roots (`meshmark saliency`)."""
    from meshmark.saliency.analysis import points_and_saliency

    welded, found = points_and_saliency(mesh)
    beta = np.sqrt(found.beta[welded.point_of_vertex])
    return heat_layer(
        "saliency",
        "Saliency",
        beta,
        ROOT_TICKS,
        note="How much a place stands out from its surroundings; eyes go there first.",
    )


def displacement_shades(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return (n, 3) linear RGB: the colours of `displacement_layer`."""
    return lit_heat(_moved(before, after)[0])


def displacement_layer(
    before: FloatArray, after: FloatArray, title: str = "Displacement", *, note: str = ""
) -> Layer:
    """Return how far each vertex moved, in per cent of the diagonal of the bounding box before.

    before, after: (n, 3) in the same order. The scale ends at the largest movement.
    """
    moved, largest = _moved(before, after)
    ticks = [(at, f"{100 * at * largest:.2g}") for at in (0.0, 0.5, 1.0)] if largest else [(0.0, "0")]
    return heat_layer(
        "displacement",
        title,
        moved,
        ticks,
        unit="Displacement, % of the diagonal",
        note=note,
    )


def _moved(before: FloatArray, after: FloatArray) -> tuple[FloatArray, float]:
    """Return (n,) how far each vertex moved over the largest movement, and that over the diagonal."""
    moved = np.linalg.norm(after - before, axis=1)
    largest = float(moved.max(initial=0.0))
    diagonal = float(np.linalg.norm(np.ptp(before, axis=0))) or 1.0
    return moved / (largest or 1.0), largest / diagonal

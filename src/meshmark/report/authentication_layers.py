"""The layers of an authentication's view: where checks failed, what became of each part, regions, saliency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from meshmark.authentication.regions.condition import CONDITIONS
from meshmark.mesh import Mesh
from meshmark.report.authentication_colours import CONDITION_COLOURS, region_shades
from meshmark.report.colours import hex_colours
from meshmark.report.common_layers import own_surface, saliency_layer
from meshmark.report.view_layer import Layer, category_layer, heat_layer

if TYPE_CHECKING:
    from meshmark.authentication.verdict import Authentication

__all__ = ["authentication_layers"]


def authentication_layers(mesh: Mesh, found: Authentication) -> list[Layer]:
    """Return the layers of a suspect, the tamper map first; what is not known of it has no layer."""
    layers = []
    if np.isfinite(found.failed_share).any():
        layers.append(
            heat_layer(
                "tamper",
                "Tamper map",
                found.failed_share,
                [(0.0, "0"), (0.5, "50"), (1.0, "100")],
                unit="Failed checks, %",
                missing="" if np.isfinite(found.failed_share).all() else "Not checked",
                note="Of the checks around each place; 100 where all of them failed.",
            )
        )
    if found.altered.any():
        layers.append(_conditions(found))
    if any(region.checks for region in found.regions):
        layers.append(_regions(found))
    return [*layers, saliency_layer(mesh), own_surface(mesh)]


def _conditions(found: Authentication) -> Layer:
    """Return what became of each place; only what occurs is in the legend."""
    there = set(np.unique(found.condition).tolist())
    entries = [
        (CONDITION_COLOURS[name][0] if number in there else "", CONDITION_COLOURS[name][1])
        for number, name in enumerate(CONDITIONS)
    ]
    return category_layer("parts", "Altered parts", found.condition, entries)


def _regions(found: Authentication) -> Layer:
    """Return the regions, each in the colour of its share of failed checks."""
    return category_layer(
        "regions",
        "Regions",
        found.region,
        [("", colour) for colour in hex_colours(region_shades(found.regions))],
        ticks=[(share**0.5, f"{100 * share:g}") for share in (0.0, 0.01, 0.1, 0.5, 1.0)],
        unit="Failed checks of the region, %",
        note="Their numbers are in the table and on the pictures below.",
    )

"""The report of an authentication: where the surface was changed, how sure that is, and what it means."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from meshmark.coding.chance import band, in_words
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.authentication_colours import failed_colours, in_order, region_shades
from meshmark.report.authentication_layers import authentication_layers
from meshmark.report.provenance import Provenance
from meshmark.report.report_page import Report, report_page, write_report_page
from meshmark.report.still_view import StillView, front_and_back
from meshmark.report.surface_view import surface_view
from meshmark.report.view_surface import PICTURE_VIEW, ViewSurface, view_surface

if TYPE_CHECKING:
    from meshmark.authentication.verdict import Authentication

__all__ = ["authentication_page", "authentication_report", "authentication_view", "write_authentication_page"]

_UNSIGNED = "Only the id"
_HEADINGS: Final = {
    "authentic": ("good", "Authentic"),
    "surface_intact": ("open", "Surface intact, but the file shows something else"),
    "altered": ("bad", "Altered"),
    "not_marked": ("open", "Not marked with this key"),
    "inconclusive": ("open", "Inconclusive"),
}
_NEXT: Final = {
    "authentic": "The model is as it was when it was marked. It may have been turned, resized, moved or converted.",
    "surface_intact": "The view shows the surface alone, which is as it was when it was marked. What a "
    "viewer shows of "
    "this file is named above.",
    "altered": "The darker the colour, the more checks failed there. `meshmark recover` brings the altered "
    "parts back, as "
    "far as the miniature in the intact part holds them.",
    "not_marked": "Either this model was never marked with this key, or it was changed everywhere.",
    "inconclusive": "A larger part of the model, or its certificate, may tell more.",
}


def write_authentication_page(
    mesh: Mesh, found: Authentication, origin: Provenance, path: Path | str, staging: Staging | None = None
) -> None:
    """Save the page of a suspect; raises `OutputError` where the page cannot be written.

    staging: takes the file, to move it into place together with others.
    """
    write_report_page(authentication_report(mesh, found, origin), path, staging)


def authentication_page(mesh: Mesh, found: Authentication, origin: Provenance) -> str:
    """Return the page of a suspect."""
    return report_page(authentication_report(mesh, found, origin))


def authentication_view(
    mesh: Mesh, found: Authentication, shown: ViewSurface | None = None
) -> dict[str, object]:
    """Return the interactive view of a suspect, as `surface_view` does.

    shown: the surface of the mesh, where it has been made already.
    """
    layers = authentication_layers(mesh, found)
    label = f"The model with its tamper map: {_HEADINGS[found.verdict][1].lower()}"
    start = layers[0].name if found.verdict != "not_marked" else "surface"
    return surface_view(shown or view_surface(mesh), layers, start=start, label=label)


def authentication_report(mesh: Mesh, found: Authentication, origin: Provenance) -> Report:
    """Return what the page of a suspect says; origin: of its file."""
    unsigned = found.verdict == "inconclusive" and found.id is not None
    tone, heading = _HEADINGS[found.verdict]
    shown = view_surface(mesh)
    return Report(
        kind="Authentication",
        answer=found.verdict,
        tone=tone,
        heading=_UNSIGNED if unsigned else heading,
        lead=found.advice,
        next="" if unsigned else _NEXT[found.verdict],
        facts=_facts(mesh, found),
        sure=_sure(found),
        provenance=origin,
        view=authentication_view(mesh, found, shown),
        pictures=_pictures(shown, found),
        regions=in_order(found.regions),
    )


def _facts(mesh: Mesh, found: Authentication) -> list[tuple[str, str]]:
    payload = {"recovered": "read in full", "partial": "damaged", "none": "none"}[found.payload]
    if found.content is not None and found.payload == "recovered":
        payload = f"{found.content.kind}, {len(found.content.content):,} bytes, read in full"
    moved, apart = found.vertices_that_are("moved"), found.vertices_that_are("cut_off")
    altered = f"{found.altered_vertices:,} vertices, {_percent(found.altered_area_fraction)} of the surface"
    cut_off = f"{apart:,} vertices, intact, parted from the rest by what was altered"
    return [
        ("Size", f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} faces"),
        ("Altered", altered),
        *([("Moved as one", f"{moved:,} of them; inside, they are as they were")] if moved else ()),
        *([("Cut off", cut_off)] if apart else ()),
        *(("Shown otherwise", cause.sentence) for cause in found.causes),
        ("Id", "none" if found.id is None else f"{found.id:016x}"),
        ("Payload", payload),
    ]


def _sure(found: Authentication) -> list[str]:
    """Return how sure the verdict is, and why."""
    checks, failed = (
        sum(counts) for counts in zip(*((r.checks, r.failed) for r in found.regions), strict=True)
    )
    sentences = []
    if checks:
        sentences.append(
            f"{checks:,} places could be checked; {failed:,} of these checks failed. A place is checked by "
            f"the marks in its "
            "closest neighbourhood."
        )
    if found.id is not None:
        words = in_words(band(found.log10_false_positive)).replace("^-", "^−")
        sentences.append(f"The chance that a model without marks of this key shows such marks is {words}.")
    return sentences or ["No mark was read, so nothing could be checked."]


def _pictures(shown: ViewSurface, found: Authentication) -> list[StillView]:
    map_ = shown.panel(failed_colours(found.failed_share))
    regions = replace(shown.panel(), colours=region_shades(found.regions), labels=found.region[shown.vertex])
    pictures = front_and_back(map_, PICTURE_VIEW, ("Tamper map, from the front", "Tamper map, from behind"))
    parted = front_and_back(
        regions, PICTURE_VIEW, ("Regions, from the front", "Regions, from behind"), numbered=True
    )
    return pictures + parted if np.isfinite(found.failed_share).any() else parted


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"

"""The report of an extraction: whether a mark is there, whose it is, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from meshmark.coding.chance import band, in_words
from meshmark.coding.message import format_id
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.common_layers import own_surface, saliency_layer
from meshmark.report.own_colours import own_colours
from meshmark.report.provenance import Provenance
from meshmark.report.report_page import Report, Table, write_report_page
from meshmark.report.still_view import front_and_back
from meshmark.report.surface_view import surface_view
from meshmark.report.view_surface import PICTURE_VIEW, ViewSurface, view_surface

if TYPE_CHECKING:
    from meshmark.ownership.extraction_result import Extraction

__all__ = ["extraction_report", "extraction_view", "write_extraction_page"]

_TONES: Final = {"present": "good", "absent": "open", "inconclusive": "open"}
_LAYERS: Final = {
    "cells": "ownership, in cells of the surface",
    "points": "ownership, at points",
    "authentication": "authentication marks",
}


def write_extraction_page(
    mesh: Mesh,
    found: Extraction,
    origin: Provenance,
    path: Path | str,
    *,
    recipients: Sequence[str] = (),
    staging: Staging | None = None,
) -> None:
    """Save the page of an extraction; raises `OutputError` where it cannot be written.

    recipients: of the ids, as a registry names them. staging: takes the file, to move it into place together with
    others.
    """
    write_report_page(extraction_report(mesh, found, origin, recipients), path, staging)


def extraction_view(mesh: Mesh, shown: ViewSurface | None = None) -> dict[str, object]:
    """Return the interactive view of a suspect, as `surface_view` does.

    shown: the surface of the mesh, where it has been made already.
    """
    layers = [own_surface(mesh), saliency_layer(mesh)]
    return surface_view(shown or view_surface(mesh), layers, start="surface", label="The model")


def extraction_report(
    mesh: Mesh, found: Extraction, origin: Provenance, recipients: Sequence[str] = ()
) -> Report:
    """Return what the page of an extraction says; recipients: of the ids, as a registry names them."""
    inconclusive = found.presence == "inconclusive"
    shown = view_surface(mesh)
    return Report(
        kind="Extraction",
        answer="unread" if inconclusive else found.presence,
        tone=_TONES[found.presence],
        heading=_heading(found),
        lead=_lead(found, recipients),
        next=found.advice,
        facts=_facts(mesh, found, recipients),
        sure=_sure(found),
        provenance=origin,
        view=extraction_view(mesh, shown),
        pictures=front_and_back(own_colours(mesh).on(shown), PICTURE_VIEW, ("From the front", "From behind")),
        tables=_evidence(found),
    )


def _heading(found: Extraction) -> str:
    if found.presence == "present":
        return "A mark of this key is present"
    return "No mark of this key" if found.presence == "absent" else "Inconclusive"


def _lead(found: Extraction, recipients: Sequence[str]) -> str:
    if not found.ids:
        if found.bits == 0:
            return "It carries no id."
        return "" if found.presence != "present" else "Its id cannot be read."
    issued = f", issued to {', '.join(recipients)}" if recipients else ""
    if len(found.ids) == 1:
        return f"The model carries the id {format_id(found.ids[0])}{issued}."
    return f"The model carries the ids {', '.join(map(format_id, found.ids))}{issued}."


def _facts(mesh: Mesh, found: Extraction, recipients: Sequence[str]) -> list[tuple[str, str]]:
    rows = [("Id", ", ".join(map(format_id, found.ids)) or "none")]
    if recipients:
        rows.append(("Recipient", ", ".join(recipients)))
    return [*rows, ("Size", f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} faces")]


def _sure(found: Extraction) -> list[str]:
    if found.presence != "present":
        return [
            "No reading was good enough to be believed: each one that was tried is counted against the mark."
        ]
    chance = in_words(band(found.log10_false_positive)).replace("^-", "^−")
    return [
        f"The chance of this answer for a model without a mark of this key is {chance}. All readings that "
        f"were tried "
        "are counted."
    ]


def _evidence(found: Extraction) -> list[Table]:
    rows = tuple(
        (
            _LAYERS[each.layer],
            ("none" if found.bits == 0 else "not read") if each.id is None else format_id(each.id),
            in_words(band(each.log10_false_positive)).replace("^-", "^−"),
            f"{100 * each.share:.0f} %",
        )
        for each in found.evidence
    )
    if not rows:
        return []
    columns = ("What was read", "Id", "Chance without a mark", "Share of the surface")
    return [Table(title="Evidence", columns=columns, rows=rows, words=2)]

"""The report of an embedding: what was put into a model, how far that moved the surface, and that it was read
back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.coding.message import format_id
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.common_layers import displacement_layer, displacement_shades, own_surface, saliency_layer
from meshmark.report.own_colours import own_colours
from meshmark.report.provenance import Provenance
from meshmark.report.report_page import Report, write_report_page
from meshmark.report.still_view import StillView, still_view
from meshmark.report.surface_view import surface_view
from meshmark.report.view_surface import PICTURE_VIEW, ViewSurface, view_surface

if TYPE_CHECKING:
    from meshmark.marking.embedding_result import Embedding

__all__ = ["embedding_report", "embedding_view", "write_embedding_page"]


def write_embedding_page(
    original: Mesh, made: Embedding, origin: Provenance, path: Path | str, staging: Staging | None = None
) -> None:
    """Save the page of an embedding; raises `OutputError` where it cannot be written.

    original: with the vertices of the marked mesh, in their order. origin: of the marked file. staging: takes the
    file, to move it into place together with others.
    """
    write_report_page(embedding_report(original, made, origin), path, staging)


def embedding_view(original: Mesh, made: Embedding, shown: ViewSurface | None = None) -> dict[str, object]:
    """Return the interactive view of a marked model, as `surface_view` does.

    shown: the surface of the marked mesh, where it has been made already.
    """
    moved = displacement_layer(
        original.vertices, made.mesh.vertices, note="Of the mark, against the original."
    )
    layers = [own_surface(made.mesh), moved, saliency_layer(made.mesh)]
    shown = shown or view_surface(made.mesh)
    return surface_view(shown, layers, start="displacement", label="The marked model")


def embedding_report(original: Mesh, made: Embedding, origin: Provenance) -> Report:
    """Return what the page of an embedding says."""
    sentences = " ".join(made.remarks)
    shown = view_surface(made.mesh)
    return Report(
        kind="Embedding",
        answer="marked",
        tone="good",
        heading="Marked",
        lead=f"The model carries {_carried(made)}. It was read back from the file with the key alone. "
        f"{sentences}".rstrip(),
        next="Keep the certificate, if you had one made: with it, the mark is found in badly damaged copies, too.",
        facts=_facts(made),
        sure=_sure(made),
        provenance=origin,
        view=embedding_view(original, made, shown),
        pictures=_pictures(original, made, shown),
    )


def _carried(made: Embedding) -> str:
    return "a mark without an id" if made.id is None else f"the id {format_id(made.id)}"


def _facts(made: Embedding) -> list[tuple[str, str]]:
    rows = [
        ("Id", "none" if made.id is None else format_id(made.id)),
        ("Layers", {"both": "ownership and authentication"}.get(made.layers, made.layers)),
        ("Strength", made.strength),
        ("Size", f"{made.vertices:,} vertices, {made.faces:,} faces"),
        (
            "Displacement",
            f"{_percent(made.rms_over_diagonal)} of the diagonal RMS, {_percent(made.max_over_diagonal)} at most",
        ),
    ]
    if made.ownership is not None:
        rows.append(
            ("Ownership", f"{'the mark' if made.id is None else 'the id'} in {made.carriers:,} places")
        )
    if made.authentication is not None:
        mark = made.authentication
        payload = f", {mark.payload_bytes:,} bytes of payload" if mark.payload_bytes else ""
        rows.append(("Authentication", f"{mark.marks:,} marks{payload}; tolerance: {mark.tolerance}"))
    return rows


def _sure(made: Embedding) -> list[str]:
    read = {
        "both": "Both layers were read back, and nothing was found altered.",
        "ownership": "The id was read back. Where the model is changed later cannot be told: it has no "
        "authentication layer.",
        "authentication": "The marks were read back, and nothing was found altered.",
    }[made.layers]
    return [f"The positions were checked as the file holds them. {read}"]


def _pictures(original: Mesh, made: Embedding, shown: ViewSurface) -> list[StillView]:
    own, shades = own_colours(original), displacement_shades(original.vertices, made.mesh.vertices)
    darkest = f"Displacement; darkest: {_percent(made.max_over_diagonal)} of the diagonal"
    panels = {
        "Original": own.on(view_surface(original)),
        "Marked": own.on(shown),
        darkest: shown.panel(shades),
    }
    return [still_view(panel, PICTURE_VIEW, caption) for caption, panel in panels.items()]


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"

"""The report of a recovery: what was restored from the miniature, and what is as it was signed off."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.view import level_view
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.authentication_colours import CONDITION_COLOURS, failed_colours, in_order
from meshmark.report.common_layers import displacement_layer, own_surface, saliency_layer
from meshmark.report.own_colours import own_colours
from meshmark.report.provenance import Provenance
from meshmark.report.report_page import Report
from meshmark.report.still_view import StillView, still_view
from meshmark.report.surface_view import surface_view
from meshmark.report.view_layer import Layer, category_layer
from meshmark.report.view_surface import PICTURE_VIEW, ViewSurface, view_surface
from meshmark.scene.stance import stance_of

if TYPE_CHECKING:
    from meshmark.authentication.part_recovery import Recovery
    from meshmark.authentication.verdict import Authentication

__all__ = ["recovery_report", "recovery_view", "restored_vertices"]

_SOURCES: Final = {
    "miniature": ("recovered", "the miniature"),
    "marked_copy": ("recovered_copy", "the marked copy, made again"),
    "original": ("recovered_original", "the original"),
}
"""Of `Recovery.restored_from`: the key in `MEANINGS`, and words."""
_READ_AS_A_WHOLE = "The miniature is sealed into the marks: it is read only where it is undamaged as a whole."
_INTACT, _RESTORED = CONDITION_COLOURS["intact"][1], CONDITION_COLOURS["moved"][1]


def restored_vertices(suspect: Mesh, whole: Mesh) -> NDArray[np.bool_]:
    """Return (n,): which vertices of the recovered mesh lie where none of the suspect does."""
    row = np.dtype([("x", "f8"), ("y", "f8"), ("z", "f8")])
    before, after = (np.ascontiguousarray(mesh.vertices + 0.0).view(row).ravel() for mesh in (suspect, whole))
    return np.asarray(~np.isin(after, before))


def recovery_view(suspect: Mesh, made: Recovery, shown: ViewSurface | None = None) -> dict[str, object]:
    """Return the interactive view of a recovered model, as `surface_view` does; `made` has a mesh.

    shown: the surface of that mesh, where it has been made already.
    """
    whole = made.mesh if made.mesh is not None else suspect
    source = made.restored_from or "miniature"
    layers: list[Layer] = [
        category_layer(
            "restored",
            "What was restored",
            restored_vertices(suspect, whole).astype(np.int64),
            [("As it was signed off", _INTACT), (f"Restored from {_SOURCES[source][1]}", _RESTORED)],
        )
    ]
    if whole.vertices.shape == suspect.vertices.shape:
        layers.append(
            displacement_layer(
                suspect.vertices, whole.vertices, "Moved back", note="Against the altered model."
            )
        )
    layers += [saliency_layer(whole), own_surface(whole)]
    label = "The recovered model, with what was restored in blue"
    return surface_view(shown or view_surface(whole), layers, start="restored", label=label)


def recovery_report(suspect: Mesh, found: Authentication, made: Recovery, origin: Provenance) -> Report:
    """Return what the page of a recovery says.

    found: what the suspect told. origin: of the recovered file. `made` has a mesh.
    """
    whole = made.mesh if made.mesh is not None else suspect
    nothing = not (made.vertices_moved or made.vertices_removed or made.faces_added)
    turn = level_view(suspect.vertices, stance_of(suspect))
    shown = view_surface(whole, turn=turn)
    source = made.restored_from or "miniature"
    share = made.altered_area_fraction
    lead = (
        f"{_percent(share)} of the surface was altered and is restored; the other {_percent(1.0 - share)} "
        f"is as it was "
        "signed off."
    )
    return Report(
        kind="Recovery",
        answer="authentic" if nothing else _SOURCES[source][0],
        tone="good",
        heading="Nothing was altered" if nothing else "Restored where it was altered",
        lead="The model is as it was signed off." if nothing else lead,
        next=made.advice,
        facts=[
            ("Altered before", f"{found.altered_vertices:,} vertices, {_percent(share)} of the surface"),
            *([] if nothing else [("Restored from", _SOURCES[source][1])]),
            ("Moved back", f"{made.vertices_moved:,} vertices"),
            ("Cut out", f"{made.vertices_removed:,} vertices"),
            ("Added", f"{made.faces_added:,} faces"),
            ("Size", f"{len(whole.vertices):,} vertices, {len(whole.faces):,} faces"),
            *([("Not kept", ", ".join(made.lost))] if made.lost else []),
        ],
        sure=[
            "What was altered is what the marks of the altered model say. Its other vertices were not "
            "touched: their "
            "coordinates are those of the file, bit by bit.",
            *_fits(made),
        ],
        provenance=origin,
        view=recovery_view(suspect, made, shown),
        pictures=_pictures(suspect, found, (whole, shown), turn),
        regions=in_order(found.regions),
        regions_title="Regions before the recovery",
    )


def _fits(made: Recovery) -> list[str]:
    """Return why what was restored can be believed."""
    if made.restored_from == "miniature":
        return [_READ_AS_A_WHOLE]
    off = made.intact_rms_over_diagonal
    if off is None:
        return []
    return [
        f"The intact vertices lie {100 * off:.1g} % of the diagonal (RMS) from those of the copy made again."
    ]


def _pictures(
    suspect: Mesh, found: Authentication, after: tuple[Mesh, ViewSurface], turn: FloatArray
) -> list[StillView]:
    before = view_surface(suspect, turn=turn)
    panels = {
        "As it was found": own_colours(suspect).on(before),
        "What was altered": before.panel(failed_colours(found.failed_share)),
        "Recovered": own_colours(after[0]).on(after[1]),
    }
    return [still_view(panel, PICTURE_VIEW, caption) for caption, panel in panels.items()]


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"

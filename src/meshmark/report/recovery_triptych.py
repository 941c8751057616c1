"""The picture of a recovery: the model as it was found, what was altered, and what was made of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.geometry.view import three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.authentication_colours import failed_colours
from meshmark.report.mesh_panel import mesh_panel
from meshmark.report.own_colours import own_panel
from meshmark.report.picture import Panel, panels
from meshmark.scene.stance import stance_of

if TYPE_CHECKING:
    from meshmark.authentication.verdict import Authentication

__all__ = ["recovery_panels", "recovery_triptych"]


def recovery_triptych(
    suspect: Mesh,
    found: Authentication,
    whole: Mesh,
    path: Path | str,
    *,
    size: int = 900,
    staging: Staging | None = None,
) -> None:
    """Save a PNG of three panels, `recovery_panels`.

    staging: takes the file, to move it into place together with others. Raises `OutputError` where the file cannot
    be written.
    """
    view = three_quarter_view(weld(suspect).points, stance_of(suspect))
    panels(recovery_panels(suspect, found, whole), path, size=size, view=view, staging=staging)


def recovery_panels(suspect: Mesh, found: Authentication, whole: Mesh) -> tuple[Panel, Panel, Panel]:
    """Return the suspect in its own colours, the same with its tamper map, and the recovered model."""
    return (
        own_panel(suspect, "as it was found"),
        mesh_panel(
            suspect, "share of failed checks: white none, red all", failed_colours(found.failed_share)
        ),
        own_panel(whole, "recovered"),
    )

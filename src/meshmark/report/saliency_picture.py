"""The picture of `meshmark saliency`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from meshmark.geometry.view import three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.colours import heat
from meshmark.report.picture import Bar, Panel, panels
from meshmark.saliency.analysis import SaliencyResult

__all__ = ["saliency_picture"]

BAR = Bar(title="saliency", ticks=tuple((beta**0.5, f"{beta:g}") for beta in (0.0, 0.05, 0.2, 0.5, 1.0)))
DOTS = 120
"""Salient points drawn at most, the strongest."""


def saliency_picture(
    mesh: Mesh,
    result: SaliencyResult,
    path: Path | str,
    *,
    size: int = 900,
    staging: Staging | None = None,
) -> None:
    """Save a PNG of beta as colour with the strongest salient points as dots, from two sides.

    staging: as in `panels`. Raises `OutputError` where the file cannot be written.
    """
    welded = weld(mesh)
    beta = result.beta[welded.vertex_of_point]
    colours = heat(np.sqrt(beta))
    marks = welded.point_of_vertex[result.salient[:DOTS]]
    drawn = f"the {len(marks)} strongest of {len(result.salient)}" if len(marks) < len(result.salient) else ""
    caption = f"{drawn or len(marks)} salient points"
    view = three_quarter_view(welded.points)
    back = welded.points @ (view.T @ np.diag([-1.0, 1.0, -1.0]) @ view)  # half a turn about the vertical
    front = Panel(caption=caption, points=welded.points, faces=welded.faces, colours=colours, marks=marks)
    behind = Panel(caption="the other side", points=back, faces=welded.faces, colours=colours, marks=marks)
    panels([front, behind], path, size=size, view=view, bar=BAR, staging=staging)

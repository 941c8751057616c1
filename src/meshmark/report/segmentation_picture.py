"""The picture of `meshmark segment`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from meshmark.geometry.weld import weld
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.colours import oklch, region_colours
from meshmark.report.picture import Panel, panels
from meshmark.segmentation.analysis import Segmentation

__all__ = ["segmentation_picture"]

GREEN_AND_BLUE = oklch(np.array([0.80, 0.70]), np.array([0.12, 0.11]), np.array([145.0, 250.0]))


def segmentation_picture(
    mesh: Mesh,
    result: Segmentation,
    path: Path | str,
    *,
    size: int = 900,
    staging: Staging | None = None,
) -> None:
    """Save a PNG of the regions beside the green and the blue half.

    staging: as in `panels`. Raises `OutputError` where the file cannot be written.
    """
    welded = weld(mesh)
    at = welded.vertex_of_point
    region, green = result.region[at], result.green[at]
    count = len(result.seeds)
    seeds = welded.point_of_vertex[result.seeds]
    shades = region_colours(region, welded.faces, count)
    parts = 2 * region + ~green
    regions = Panel(
        caption=f"{count} regions, balance {result.balance:.3f}",
        points=welded.points,
        faces=welded.faces,
        colours=shades,
        labels=region,
        marks=seeds,
    )
    halves = Panel(
        caption="each with its share of the green and the blue half",
        points=welded.points,
        faces=welded.faces,
        colours=np.tile(GREEN_AND_BLUE, (count, 1)),
        labels=parts,
        marks=seeds,
    )
    panels([regions, halves], path, size=size, staging=staging)

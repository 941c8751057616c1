"""Map segmentation of a whole model, per vertex of its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.saliency.analysis import points_and_saliency
from meshmark.saliency.salient_points import salient_points
from meshmark.segmentation.map_segmentation import choose_seeds, default_regions, map_regions

__all__ = ["Segmentation", "segment"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Segmentation:
    """What `meshmark segment` reports.

    region:      (n,) region of each vertex of the file, 0 to k - 1, the strongest salient point first.
    green:       (n,) whether the vertex lies in the green (top) half.
    seeds:       (k,) the vertex at the salient point of each region.
    green_share: (k,) part of the green area in each region; blue_share: the same of the blue area.
    balance:     largest share over mean share, 1 is perfect.
    """

    region: IntArray
    green: NDArray[np.bool_]
    seeds: IntArray
    green_share: FloatArray
    blue_share: FloatArray
    balance: float

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields `regions` and `balance`."""
        regions = [
            {"id": i, "green_share": float(green), "blue_share": float(blue), "salient_vertex": int(seed)}
            for i, (green, blue, seed) in enumerate(
                zip(self.green_share, self.blue_share, self.seeds, strict=True)
            )
        ]
        return {"regions": regions, "balance": self.balance}


def segment(mesh: Mesh, regions: int | None = None) -> Segmentation:
    """Split `mesh` into regions around its salient points.

    Parameters
    ----------
    mesh : Mesh
        A surface of n vertices, closed or open.
    regions : int, optional
        How many regions, 1 to the number of points; by default 2 to 32, by the size of the model.

    Returns
    -------
    Segmentation
        The region (n,) and the half (n,) of each vertex, and each region's share of both halves.

    Raises
    ------
    InputError
        There is no surface, or `regions` is out of range.
    """
    welded, found = points_and_saliency(mesh)
    count = default_regions(len(welded.points)) if regions is None else regions
    if not 1 <= count <= len(welded.points):
        raise InputError(f"{count} regions asked for, expected 1 to {len(welded.points)}, one for each point")
    peaks = salient_points(found.beta, welded.points, found.walk, rings=found.rings)
    seeds = choose_seeds(welded.points, found.beta, peaks, count)
    parted = map_regions(welded.points, welded.faces, seeds)
    at = welded.point_of_vertex
    return Segmentation(
        region=parted.region[at],
        green=parted.green[at],
        seeds=welded.vertex_of_point[seeds],
        green_share=parted.green_share,
        blue_share=parted.blue_share,
        balance=parted.balance,
    )

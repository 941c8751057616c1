"""The map of a suspect: its regions, the verdict on each, and where in the model they lie."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.examination import Examination
from meshmark.authentication.regions.condition import CONDITIONS, conditions
from meshmark.authentication.regions.failed_share import failed_share
from meshmark.authentication.regions.region import Region, judge_regions
from meshmark.authentication.regions.region_evidence import region_evidence
from meshmark.geometry.view import Stance
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.scene.stance import stance_of
from meshmark.segmentation.analysis import segment
from meshmark.segmentation.map_segmentation import Regions
from meshmark.segmentation.region_labels import region_labels

__all__ = ["RegionMap", "region_map"]


@dataclass(frozen=True, eq=False, kw_only=True)
class RegionMap:
    """regions: of the map, in their order; region: (n,) the one of each vertex of the file.

    failed_share: (n,) share of the checks around each vertex that failed, 0 to 1, NaN where nothing was checked.
    condition: (n,) of each vertex, an index into `CONDITIONS`. stance: of the model, where its file says so.
    """

    regions: tuple[Region, ...]
    region: IntArray
    failed_share: FloatArray
    condition: IntArray
    stance: Stance | None = None

    def places(self) -> list[str]:
        """Return where the altered regions lie, in words, the most altered first, each place once."""
        called = [region for region in self.regions if region.verdict == "altered"]
        return list(dict.fromkeys(region.where for region in sorted(called, key=lambda one: -one.failed)))

    def places_of(self, vertices: FloatArray, some: NDArray[np.bool_]) -> list[str]:
        """Return where in the model of `vertices` (n, 3) `some` (n,) of them lie, in words, region by region."""
        regions = np.unique(self.region[some])
        middles = [vertices[some & (self.region == region)].mean(axis=0) for region in regions]
        if not middles:
            return []
        return list(dict.fromkeys(region_labels(vertices, np.array(middles), self.stance)))


def region_map(mesh: Mesh, found: Examination, altered: NDArray[np.bool_]) -> RegionMap:
    """Return the map of a suspect of which the points `altered` (p,) were altered.

    Where no mark holds there is nothing to judge: all regions are altered, or none is checked.
    """
    map_ = segment(mesh)
    points = found.surface.points
    first = found.surface.vertex_of_point
    regions = Regions(
        region=map_.region[first],
        green=map_.green[first],
        green_share=map_.green_share,
        blue_share=map_.blue_share,
    )
    centres = _centres(points, found.surface.point_shares, regions, altered)
    judged = judge_regions(region_evidence(found.surface.graph, regions, found.checks, altered), centres)
    if not found.marked:
        called, chance = ("altered", 1.0) if altered.any() else ("unchecked", 0.0)
        judged = tuple(
            replace(region, verdict=called, probability=chance, checks=0, failed=0, log10_chance=0.0)
            for region in judged
        )
    stance = stance_of(mesh)
    words = region_labels(points, centres, stance)
    judged = tuple(replace(region, where=where) for region, where in zip(judged, words, strict=True))
    if found.marked:
        share = failed_share(found.surface.graph, found.checks, altered)
        condition = conditions(found.surface.graph, found.checks, altered)
    else:
        share = np.full(len(points), np.nan)
        condition = np.full(len(points), CONDITIONS.index("altered" if altered.any() else "unchecked"))
    return RegionMap(
        regions=judged,
        region=map_.region,
        failed_share=share[found.surface.point_of_vertex],
        condition=condition[found.surface.point_of_vertex],
        stance=stance,
    )


def _centres(
    points: FloatArray, areas: FloatArray, regions: Regions, altered: NDArray[np.bool_]
) -> FloatArray:
    """Return (n, 3): the middle of the altered surface of each region, of all its surface where none is."""
    count = len(regions.green_share)
    held = np.bincount(regions.region, areas * altered, count) > 0.0
    areas = np.where(held[regions.region], areas * altered, areas)
    weight = np.bincount(regions.region, areas, count)
    moments = [np.bincount(regions.region, areas * points[:, axis], count) for axis in range(3)]
    return np.asarray(np.stack(moments, axis=1) / np.where(weight > 0.0, weight, 1.0)[:, None])

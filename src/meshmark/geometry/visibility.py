"""How visible a change of a surface is, from the change of its normals.

A viewer sees shading, so normals, not positions, and sees a change best where the surface was smooth. In a patch
around each of many points spread over the surface:

    change     RMS angle between the normals before and after, degrees
    detail     RMS angle of the normals before from their best linear fit over the patch, degrees
    ratio      change / (JUST_NOTICED + MASKING detail)

A patch with a ratio above 1 is visible; the visible share is that of the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Visibility", "VisibleChange"]

# Radius of a patch over the bounding-box diagonal, a change in degrees that is just noticed on a smooth patch, and
# the share of a patch's own detail that hides a change.
RADIUS = 0.025
JUST_NOTICED = 0.75
MASKING = 0.5
PATCHES = 1500
# Points of a patch that are used at most, and at least.
MOST, LEAST = 250, 8
# Normals of one patch: others are of the far side of a thin wall.
SAME_SIDE = 0.3


@dataclass(frozen=True, kw_only=True)
class Visibility:
    """How visible a change is.

    share: of the surface where it is visible, 0 to 1. median, p95: of the ratio over the surface.
    smooth: RMS change of normals, degrees, over the smoothest quarter of the surface.
    """

    share: float
    median: float
    p95: float
    smooth: float


class VisibleChange:
    """The patches of one surface, to judge displacements of its points by.

    Points (p, 3) that faces use; equal points must be one. Patches are spread over the area by a fixed seed.
    """

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        self._faces = faces
        areas, self._normals = vertex_areas_and_normals(points, faces)
        used = np.flatnonzero(areas > 0.0)
        rng = np.random.default_rng(0)
        radius = RADIUS * float(np.linalg.norm(np.ptp(points[used], axis=0)))
        share = np.cumsum(areas[used])
        stratified = (np.arange(PATCHES) + rng.random(PATCHES)) / PATCHES * share[-1]
        centres = used[np.minimum(np.searchsorted(share, stratified), len(used) - 1)]
        self.centres = centres
        tree = kd_tree(points[used])
        rows, columns, values, detail = [], [], [], np.zeros(PATCHES)
        for row, centre in enumerate(centres):
            near = used[tree.query_ball_point(points[centre], radius)]
            near = near[self._normals[near] @ self._normals[centre] > SAME_SIDE]
            if len(near) < LEAST:
                near = used[tree.query(points[centre], min(LEAST, len(used)))[1]]
            elif len(near) > MOST:
                near = near[:: len(near) // MOST]
            weight = areas[near] / areas[near].sum()
            detail[row] = _detail(points[near] - points[centre], self._normals[near], weight)
            rows.append(np.full(len(near), row))
            columns.append(near)
            values.append(weight)
        self._mean = sp.csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(PATCHES, len(points)),
        )
        self._noticed = JUST_NOTICED + MASKING * detail
        self._smooth = detail <= np.quantile(detail, 0.25)

    def noticed_at(self, mass: FloatArray, stiff: sp.csr_array) -> FloatArray:
        """Return the change in degrees (p,) that is just noticed at each point."""
        from meshmark.geometry.stiffness import diffused

        seen = self._mean.T
        values = np.column_stack([seen @ self._noticed, seen @ np.ones(PATCHES)])
        spread = diffused(values / mass[:, None], mass, stiff, 0.3)
        average = spread[:, 0] / np.maximum(spread[:, 1], 1e-12)
        return np.asarray(np.where(spread[:, 1] > 1e-9, average, np.median(self._noticed)))

    def ratios(self, points: FloatArray) -> FloatArray:
        """Return the ratio of each patch where the points (p, 3) are there now."""
        return self._change(points) / self._noticed

    def of(self, points: FloatArray) -> Visibility:
        """Return how visible it is that the points (p, 3) are there now."""
        change = self._change(points)
        ratio = change / self._noticed
        return Visibility(
            share=float((ratio > 1.0).mean()),
            median=float(np.median(ratio)),
            p95=float(np.quantile(ratio, 0.95)),
            smooth=float(np.sqrt((change[self._smooth] ** 2).mean())),
        )

    def _change(self, points: FloatArray) -> FloatArray:
        _, normals = vertex_areas_and_normals(points, self._faces)
        chord = np.linalg.norm(normals - self._normals, axis=1)
        angle = np.degrees(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))
        return np.asarray(np.sqrt(self._mean @ angle**2))


def _detail(places: FloatArray, normals: FloatArray, weight: FloatArray) -> float:
    """Return the RMS angle, degrees, of normals (k, 3) from their best linear fit over places (k, 3)."""
    root = np.sqrt(weight)[:, None]
    design = np.column_stack([np.ones(len(places)), places]) * root
    values = normals * root
    fit = np.linalg.lstsq(design, values, rcond=None)[0]
    rest = values - design @ fit
    return float(np.degrees(np.sqrt((rest**2).sum())))

"""Regions by clustering instead of a map: k-means and fuzzy c-means, which the paper's ablation puts there."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import FloatArray, IntArray
from meshmark.segmentation.centres import converged_centres, lloyd_iterations
from meshmark.segmentation.map_segmentation import Regions, halves
from meshmark.segmentation.power_diagram import CHUNK, assign

__all__ = ["fuzzy_c_means_regions", "k_means_regions", "memberships"]


def k_means_regions(points: FloatArray, faces: IntArray, seeds: IntArray) -> Regions:
    """Return the k-means clusters of points (p, 3), weighted by area, started from `seeds` (n,).

    Raises `InputError` where the faces have no area.
    """
    areas = vertex_areas(points, faces)
    points = canonical_frame(points, faces).to_canonical(points)  # groups of points turn with the model
    return _regions(points, areas, converged_centres(points, areas, points[seeds]))


def fuzzy_c_means_regions(points: FloatArray, faces: IntArray, seeds: IntArray) -> Regions:
    """Return for each point the cluster it belongs to most: fuzzy c-means, weighted by area, started from `seeds`.

    Bezdek 1981 with exponent 2. Raises `InputError` where the faces have no area.
    """
    areas = vertex_areas(points, faces)
    points = canonical_frame(points, faces).to_canonical(points)

    def held(centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        sums, mass = np.zeros(centres.shape), np.zeros(len(centres))
        for start in range(0, len(points), CHUNK):
            part = slice(start, start + CHUNK)
            weight = memberships(points[part], centres) ** 2 * areas[part, None]
            sums += weight.T @ points[part]
            mass += weight.sum(axis=0)
        return sums, mass

    extent = float(np.ptp(points, axis=0).max())
    return _regions(points, areas, lloyd_iterations(held, points[seeds], extent))


def memberships(points: FloatArray, centres: FloatArray) -> FloatArray:
    """Return (p, n), rows of sum 1: inverse squared distances to the centres, shared out (exponent 2)."""
    gap = points[:, None] - centres
    square = np.einsum("pnk,pnk->pn", gap, gap)
    nearest = square.min(axis=1, keepdims=True)
    # over the nearest, so that a point on a centre gives no division by zero: all is that centre's
    share = np.where(nearest > 0.0, nearest / np.where(square > 0.0, square, 1.0), square == 0.0)
    return np.asarray(share / share.sum(axis=1, keepdims=True))


def _regions(canonical: FloatArray, areas: FloatArray, centres: FloatArray) -> Regions:
    count = len(centres)
    region = assign(canonical, centres, np.zeros(count))
    green = halves(canonical, areas)
    shares = []
    for half in (green, ~green):
        held = np.bincount(region[half], areas[half], count)
        shares.append(held / (held.sum() or 1.0))
    return Regions(region=region, green=green, green_share=shares[0], blue_share=shares[1])

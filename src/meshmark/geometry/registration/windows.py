"""What a Gaussian window around an oriented point sees of one side of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.registration.surfels import Surfels
from meshmark.mesh import FloatArray

__all__ = ["Seen", "look"]

# Windows end at this many widths; what is beyond weighs less than 5 %.
REACH = 2.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Seen:
    """Per window (n): mean height over the tangent plane, its mean place (n, 3), which way the surface faces.

    masses: surface in the window, seen along the normal, over that of a plane; 0 where there is none.
    flatness: 0 to 1, how much the pieces face the same way.
    """

    heights: FloatArray
    middles: FloatArray
    facing: FloatArray
    masses: FloatArray
    flatness: FloatArray


def look(surfels: Surfels, places: FloatArray, normals: FloatArray, width: float) -> Seen:
    """Look at the surface around n places (n, 3) with unit normals (n, 3), through windows of this width.

    Pieces count by their area as seen along the normal; those that face away do not count.
    """
    pairs = kd_tree(places).sparse_distance_matrix(surfels.tree, REACH * width, output_type="ndarray")
    rows, columns = pairs["i"], pairs["j"]
    facing = surfels.normals.take(columns, axis=0)
    along = np.einsum("ij,ij->i", facing, normals.take(rows, axis=0))
    weight = surfels.areas.take(columns) * np.exp(-0.5 * (pairs["v"] / width) ** 2) * np.maximum(along, 0.0)
    step = surfels.places.take(columns, axis=0) - places.take(rows, axis=0)
    count = len(places)
    total = np.bincount(rows, weight, count)
    safe = np.where(total > 0.0, total, 1.0)
    middle = np.stack([np.bincount(rows, weight * x, count) for x in step.T], axis=1) / safe[:, None]
    turned = np.stack([np.bincount(rows, weight * x, count) for x in facing.T], axis=1) / safe[:, None]
    length = np.sqrt(np.einsum("ij,ij->i", turned, turned))
    some = length > 0.0
    turned[some] /= length[some, None]
    turned[~some] = normals[~some]
    heights = np.einsum("ij,ij->i", middle, normals)
    return Seen(
        heights=heights,
        middles=places + middle,
        facing=turned,
        masses=total / (2.0 * np.pi * width**2),
        flatness=length,
    )

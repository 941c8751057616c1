"""Landmarks: oriented points spread over a surface, each the centre of a smooth window of it.

A landmark is no point of the surface. It lies where the mean height of the surface over the landmark's tangent
plane, within a Gaussian window, is zero: noise averages out there, and another triangulation hardly moves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.registration.descriptors import describe
from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.registration.windows import look
from meshmark.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


__all__ = ["RADIUS", "WIDTH", "Landmarks", "make_landmarks", "spread"]

WIDTH = 0.08
"""Width of the windows in units of the frame's scale."""
RADIUS = 0.5
"""Radius of the balls that descriptors see, in units of the frame's scale."""
# Two sides of a sheet count as this far apart, in units of the frame's scale, when landmarks are spread.
SIDE_DISTANCE = 0.1
LEAST_FLATNESS = 0.4


@dataclass(frozen=True, eq=False, kw_only=True)
class Landmarks:
    """n landmarks in canonical coordinates (unit: the frame's scale).

    places, normals: (n, 3); masses: (n,) surface in the window over that of a plane; curvatures: (n,) how far the
    mean height of a wider window lies above; descriptors: (n, DESCRIPTOR_LENGTH); explains: the share, above
    0 to 1, of their own surface that lies in the tangent plane of a landmark nearby (see `judging`).
    """

    places: FloatArray
    normals: FloatArray
    masses: FloatArray
    curvatures: FloatArray
    descriptors: FloatArray
    explains: float

    @cached_property
    def tree(self) -> cKDTree:
        """The places, prepared for searches."""
        return kd_tree(self.places)

    def __len__(self) -> int:
        return len(self.places)


def spread(surfels: Surfels, count: int, side_distance: float) -> IntArray:
    """Return up to `count` surfels far from each other: each is the farthest from those before it.

    Where they lie and which way they face both count, a turn of 60 degrees as much as `side_distance`.
    """
    where = np.concatenate([surfels.places, side_distance * surfels.normals], axis=1)
    middle = surfels.areas @ where / max(surfels.areas.sum(), np.finfo(float).tiny)
    squared = np.einsum("ij,ij->i", where, where)
    chosen = np.empty(min(count, len(surfels)), np.int64)
    if not len(chosen):
        return chosen
    chosen[0] = np.argmax(squared - 2.0 * (where @ middle))
    nearest = np.full(len(surfels), np.inf)
    for i in range(len(chosen)):
        last = chosen[i]
        np.minimum(nearest, squared + squared[last] - 2.0 * (where @ where[last]), out=nearest)
        if i + 1 < len(chosen):
            chosen[i + 1] = np.argmax(nearest)
    return chosen


def make_landmarks(surfels: Surfels, coarse: Surfels, count: int) -> Landmarks:
    """Return up to `count` landmarks of a surface given in canonical coordinates, in fine and in coarse pieces.

    Of folded or very thin parts there are none. What they explain is taken to be everything.
    """
    rows = spread(surfels, count, SIDE_DISTANCE)
    places, normals = surfels.places[rows], surfels.normals[rows]
    for _ in range(3):
        seen = look(surfels, places, normals, WIDTH)
        normals = seen.facing
        places = places + seen.heights[:, None] * normals
    seen = look(surfels, places, normals, WIDTH)
    good = (seen.flatness > LEAST_FLATNESS) & (seen.masses > 0.0)
    places, normals = places[good], normals[good]
    wide = look(surfels, places, normals, 1.5 * WIDTH)
    curvature = wide.heights - seen.heights[good]
    described = describe(coarse, places, normals, RADIUS)
    return Landmarks(
        places=places,
        normals=normals,
        masses=seen.masses[good],
        curvatures=curvature,
        descriptors=described,
        explains=1.0,
    )

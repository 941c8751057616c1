"""MSDM2, the mesh structural distortion measure: how visible is the difference between two models?

G. Lavoué, "A multiscale metric for 3D mesh visual quality assessment", 2011, 10.1111/j.1467-8659.2011.02017.x.
Curvature at three radii is compared in Gaussian windows: its mean, its contrast and its pattern. Constants and the
details that the paper leaves open are those of the reference values in ../shared/data/msdm2 (docs/decisions/0005).
"""

from __future__ import annotations

import numpy as np

from meshmark.geometry.closest_point import Nearest
from meshmark.geometry.curvature_tensor import principal_curvatures
from meshmark.geometry.growth import HalfEdges, grow_all, half_edges
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.metrics.measured_surface import MeasuredSurface, surface_of
from meshmark.metrics.window_statistics import Fields, local_values

__all__ = ["msdm2", "msdm2_map", "msdm2_symmetric"]

RADII = (0.002, 0.003, 0.004)  # of the longest side of the judged model's bounding box
WINDOW = 5.0  # radius of a window over the radius of curvature
# Beyond MOST_WINDOWS points the mean runs over SOME_WINDOWS of them, evenly spread over their order, which changes
# it by a few thousandths of itself: windows around each of a million points hold a thousand points each.
MOST_WINDOWS, SOME_WINDOWS = 60_000, 20_000


def msdm2(a: Mesh, b: Mesh) -> float:
    """Return how visible the difference of `b` is to one who knows `a`, 0 (equal) to 1.

    a: the original; b: the degraded model, whose vertices are judged and matched to the closest points of `a`.
    The value is the 3rd-power mean over the points of the surface of `b`; swapped arguments give another value.
    Coincident vertices are one point. Above 60,000 points 20,000 of them are judged. Raises `InputError` where a
    model has no triangle with three different corners.
    """
    original, judged = surface_of(a), surface_of(b)
    chosen = np.unique(judged.faces)
    if len(chosen) > MOST_WINDOWS:
        chosen = chosen[(np.arange(SOME_WINDOWS) * len(chosen)) // SOME_WINDOWS]
    return float(np.cbrt(np.mean(_local(original, judged, chosen) ** 3)))


def msdm2_symmetric(a: Mesh, b: Mesh) -> float:
    """Return the mean of `msdm2` in both directions, 0 to 1; raises as `msdm2` does."""
    return 0.5 * (msdm2(a, b) + msdm2(b, a))


def msdm2_map(a: Mesh, b: Mesh) -> FloatArray:
    """Return (n,): the local values at the vertices of `b`, 0 to 1, 0 at loose ones; raises as `msdm2` does."""
    original, judged = surface_of(a), surface_of(b)
    out, used = np.zeros(len(judged.points)), np.unique(judged.faces)
    out[used] = _local(original, judged, used)
    return out[judged.point_of_vertex]


def _local(original: MeasuredSurface, judged: MeasuredSurface, chosen: IntArray) -> FloatArray:
    """Return the local values at the chosen points of the judged surface, the mean over the radii.

    All lengths are in longest sides of the judged model, in which curvature has no unit.
    """
    if judged.equals(original):  # where sheets coincide the closest point may lie on another one
        return np.zeros(len(chosen))
    nearest = judged.nearest_on(original)
    corners = original.faces[nearest.faces]
    points, theirs = judged.scaled(judged.points), judged.scaled(original.points)
    graph, roughness = _roughness(points, judged.all_faces)
    _, other = _roughness(theirs, original.all_faces)
    weights = _area_weights(theirs, corners, points, nearest)
    matched = np.einsum("lnc,nc->ln", other[:, corners], weights)
    fields = Fields(own=roughness, theirs=matched, matched=judged.scaled(nearest.points))
    out = np.empty(len(chosen))
    done = 0
    for growth in grow_all(points, graph, chosen, WINDOW * max(RADII)):
        values = [
            local_values(growth, graph, fields, level, WINDOW * radius) for level, radius in enumerate(RADII)
        ]
        out[done : done + len(growth.centres)] = np.mean(values, axis=0)
        done += len(growth.centres)
    return out


def _roughness(points: FloatArray, faces: IntArray) -> tuple[HalfEdges, FloatArray]:
    """Return the edges, and (k, p): at each radius half the sum of the magnitudes of both principal curvatures."""
    graph = half_edges(points, faces)
    curvatures = principal_curvatures(points, faces, graph, RADII)
    return graph, np.asarray(np.abs(curvatures).sum(axis=2) * 0.5)


def _area_weights(points: FloatArray, corners: IntArray, queries: FloatArray, nearest: Nearest) -> FloatArray:
    """Return (n, 3): shares of the corners of the matched face, from areas seen from the query point itself.

    The reference values take the unprojected point, so this does; where all areas are 0 the true shares serve.
    """
    sides = [points[corners[:, i]] - queries for i in range(3)]
    areas = np.stack(
        [np.linalg.norm(np.cross(sides[i], sides[j]), axis=1) for i, j in ((1, 2), (2, 0), (0, 1))], axis=1
    )
    total = areas.sum(axis=1, keepdims=True)
    return np.where(total > 0.0, areas / np.where(total > 0.0, total, 1.0), nearest.weights)

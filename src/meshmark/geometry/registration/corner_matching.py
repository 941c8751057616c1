"""Registration of coarse models, of which a part may be gone, by triangles that kept their shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.areas import face_areas
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.similarity import Similarity, fit_similarity
from meshmark.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["MOST_CORNERS", "corners_to_keep", "match_corners"]

MOST_CORNERS = 100
"""Triangles of a model that are kept."""
# The smallest faces, slivers among them, are not kept: this share of all may be.
_SOUND = 0.75
# Triangles of a suspect that are looked at, the largest.
_LOOKED_AT = 4000
# Shapes of triangles agree when two ratios of their edges do, to this.
_ALIKE = 0.004
# Pairs of triangles of like shape that are tried, those of the rarest shapes first.
_TRIED = 3000
# A corner is found where a point of the suspect is so near, over the scale of the model.
_NEAR = 0.004
# Corners that a first look asks for, and the share of them that must be found.
_FIRST, _SHARE = 24, 0.15
# Fewest corners that are found of a model that is worth a look.
_LEAST = 6
# Similarities that are returned, and how far they are apart, over the scale: nearer ones are the same.
_KEPT, _APART = 5, 0.02


def corners_to_keep(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return the corners (k, 3, 3) of faces, `MOST_CORNERS` at most; in the unit of the points.

    Half of them are of the largest faces, the others of all sizes: a part that holds most of the surface need not
    hold most of the points.
    """
    large = _largest(points, faces, len(faces))
    half = MOST_CORNERS // 2
    rest = large[half : max(int(_SOUND * len(large)), half)]
    if len(rest) > half:
        rest = rest[np.linspace(0, len(rest) - 1, half).astype(np.int64)]
    return np.concatenate([large[:half], rest])


def match_corners(corners: FloatArray, points: FloatArray, faces: IntArray) -> list[Similarity]:
    """Return similarities that take kept corners to points of a suspect, those that find most, and nearest, first.

    Parameters
    ----------
    corners : (k, 3, 3) float array
        Triangles of the model, in canonical coordinates.
    points : (p, 3) float array
        Of the suspect.
    faces : (m, 3) int array

    Returns
    -------
    list of Similarity
        At most five; none where too few corners are found.
    """
    theirs, theirs_shape = _by_edges(_largest(points, faces, _LOOKED_AT))
    ours, ours_shape = _by_edges(corners)
    if not len(theirs) or not len(ours):
        return []
    pairs = np.asarray(kd_tree(theirs_shape).query_ball_point(ours_shape, _ALIKE))
    rarest = np.argsort(np.array([len(each) for each in pairs]), kind="stable")
    tried = [(ours[row], theirs[other]) for row in rarest for other in sorted(pairs[row])][:_TRIED]
    tree = kd_tree(points)
    places = np.unique(corners.reshape(-1, 3), axis=0)
    first = places[:: max(len(places) // _FIRST, 1)]
    found: list[tuple[float, Similarity]] = []
    for source, target in tried:
        guess = fit_similarity(source, target)
        if _found(guess, first, tree)[0].mean() < _SHARE:
            continue
        seen, nearest = _found(guess, places, tree)
        if seen.sum() < _LEAST or seen.mean() < _SHARE:
            continue
        fit = fit_similarity(places[seen], points[nearest[seen]])
        closeness = _closeness(fit, places, tree)
        if all(not _same(fit, other, places) or closeness > known for known, other in found):
            found = [entry for entry in found if not _same(fit, entry[1], places)] + [(closeness, fit)]
    found.sort(key=lambda entry: -entry[0])
    return [fit for _, fit in found[:_KEPT]]


def _largest(points: FloatArray, faces: IntArray, most: int) -> FloatArray:
    """Return the corners (k, 3, 3) of the largest faces, at most `most`."""
    order = np.argsort(-face_areas(points, faces), kind="stable")
    return np.asarray(points[faces[order[:most]]])


def _by_edges(triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return triangles (k, 3, 3) with area, and (k, 2) both shorter edges over the longest.

    Corners are in the order of the edges opposite to them, the longest first.
    """
    opposite = np.linalg.norm(np.roll(triangles, -1, axis=1) - np.roll(triangles, -2, axis=1), axis=2)
    order = np.argsort(-opposite, axis=1, kind="stable")
    edges = np.take_along_axis(opposite, order, axis=1)
    sound = edges[:, 2] > 1e-6 * edges[:, 0]
    sorted_corners = np.take_along_axis(triangles, order[:, :, None], axis=1)
    return sorted_corners[sound], edges[sound, 1:] / edges[sound, :1]


def _found(guess: Similarity, places: FloatArray, tree: cKDTree) -> tuple[NDArray[np.bool_], IntArray]:
    distance, nearest = tree.query(guess(places), distance_upper_bound=_NEAR * guess.scale)
    return np.isfinite(distance), np.asarray(nearest, dtype=np.int64)


def _closeness(fit: Similarity, places: FloatArray, tree: cKDTree) -> float:
    """Return the share of places that are found, each counting more the nearer it is; less of a symmetric fit."""
    near = _NEAR * fit.scale
    distance, _ = tree.query(fit(places), distance_upper_bound=near)
    return float(1.0 - np.minimum(distance / near, 1.0).mean())


def _same(one: Similarity, other: Similarity, places: FloatArray) -> bool:
    apart = np.sqrt(np.mean((one(places) - other(places)) ** 2)) / one.scale
    return bool(apart < _APART)

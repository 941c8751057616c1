"""Recovery of a model with altered parts from its miniature (docs/design.md, section 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import area_vectors
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.components import connected_parts
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.borders import border_edges
from meshmark.recovery.expected_error import expected_errors
from meshmark.recovery.hole_filling import fill_holes
from meshmark.recovery.lost_components import with_lost_components
from meshmark.recovery.miniature import read_miniature
from meshmark.recovery.miniature_placement import place_miniature
from meshmark.recovery.miniature_projection import MiniatureProjection, spreads

__all__ = ["Recovered", "recover"]

# A part of its own that lies off the miniature by less than this share of what the intact part does is as it was;
AS_IT_WAS = 0.7
# one that is connected to the rest, where it is off by at most this many times the expected error. From SURE times
# the expected error on it goes all the way back, below less far (Wiener filter), as the miniature may be as wrong.
AS_EXPECTED, SURE = 1.1, 3.0
# A part is cut out where it cannot be moved back: this share of its faces turn over.
TURNED = 0.1
# A part is the boundary of a hole that has more than this share of its points on a border.
MOSTLY_BOUNDARY = 0.15
MOST_JUDGES = 20_000


@dataclass(frozen=True, eq=False, kw_only=True)
class Recovered:
    """A recovered surface of q points.

    points: (q, 3); faces: (m, 3). origin: (q,) the point of the suspect that each one was, -1 for one that is new.
    moved: (q,) whether a point that was there lies elsewhere; added: (m,) whether a face is new. left: how many
    altered parts stay as they are, since the miniature is itself off by about as much.
    """

    points: FloatArray
    faces: IntArray
    origin: IntArray
    moved: NDArray[np.bool_]
    added: NDArray[np.bool_]
    left: int


def recover(
    suspect: Surface, altered: NDArray[np.bool_], miniature: bytes, *, missing: bool = False
) -> Recovered:
    """Return the suspect with its altered parts as the miniature has them; what is not altered stays bit by bit.

    altered: (p,) of the suspect's points. Moved parts are moved back; parts of their own, and those that cannot be
    moved back, are cut out; holes are filled. missing: points are known to be gone, so connected components of
    which nothing is left are put back. Raises `InputError` where the mask does not match the suspect, and
    where the miniature is damaged or does not fit the rest.
    """
    if altered.shape != (len(suspect.points),):
        raise InputError(f"{len(altered)} points are called altered or not, expected {len(suspect.points)}")
    places, mini_faces = read_miniature(miniature)
    used = np.zeros(len(suspect.points), bool)
    used[suspect.faces] = True
    intact = np.flatnonzero(used & ~altered)
    pose = place_miniature((places, mini_faces), suspect.points, suspect.faces, intact)
    mini = (pose(places), mini_faces)
    points, cut, opened, left = _moved_back(suspect, altered & used, intact, mini)
    out = cut[suspect.faces].any(axis=1)
    opened[suspect.faces[out]] = True
    filled = fill_holes(points, suspect.faces[~out], altered | opened, opened, mini)
    places = _blended(filled.points, filled.faces, len(points), mini)
    faces = filled.faces
    if missing:
        off = SurfaceIndex(*mini).nearest(suspect.points[_few(intact)]).distances
        places, faces = with_lost_components(places, faces, mini, float(np.sqrt(np.mean(off**2))))
    return _result(suspect, places, faces, old=int((~out).sum()), left=left)


def _blended(points: FloatArray, faces: IntArray, old: int, mini: tuple[FloatArray, IntArray]) -> FloatArray:
    """Return the points, those of the filling smoothed into the surface around it."""
    new = np.arange(len(points)) >= old
    if not new.any():
        return points
    graph = adjacency(unique_edges(faces), len(points))
    return MiniatureProjection(points, faces, graph, new, mini).smoothed(new, points)


def _moved_back(
    suspect: Surface, altered: NDArray[np.bool_], intact: IntArray, mini: tuple[FloatArray, IntArray]
) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.bool_], int]:
    """Return the points after each altered part was moved back, which ones are to be cut out, which ones lie on
    boundaries of holes, and how many parts stay as they are.

    A part that is mostly border is what is left around a hole, which nobody moved. What differs by no more than the
    miniature itself is off stays as it is.
    """
    graph = adjacency(unique_edges(suspect.faces), len(suspect.points))
    part = np.maximum(connected_parts(graph, altered), 0)
    projection = MiniatureProjection(suspect.points, suspect.faces, graph, altered, mini)
    usual = float(np.sqrt(np.mean(projection.index.nearest(suspect.points[_few(intact)]).distances ** 2)))
    size = np.bincount(part[altered], minlength=int(part.max(initial=-1)) + 1)
    spread = spreads(part[altered], projection.distances() ** 2, len(size))
    expected = expected_errors(suspect.points, graph, intact, mini, size)
    tied = np.zeros(len(size), bool)
    tied[part[altered & (np.asarray(graph @ (~altered).astype(float)) > 0.0)]] = True
    border = np.zeros(len(altered), bool)
    border[border_edges(suspect.faces)] = True
    boundary = np.bincount(part[altered], border[altered], len(size)) > MOSTLY_BOUNDARY * size
    keep = np.where(tied, spread <= AS_EXPECTED * expected, spread <= AS_IT_WAS * usual) | (boundary & tied)
    moving = altered & (~keep & tied)[part]
    confidence = 1.0 - (expected / np.maximum.reduce([spread, expected, np.full(len(size), 1e-300)])) ** 2
    confidence = np.clip(confidence / (1.0 - SURE**-2), 0.0, 1.0)
    points = suspect.points + confidence[part][:, None] * (projection.project(moving) - suspect.points)
    turned = _turned(points, suspect.faces, moving, projection.index, mini)
    share = np.bincount(part[altered], turned[altered], len(size)) / np.maximum(size, 1)
    cut = altered & ((~keep & ~tied) | (share > TURNED))[part]
    left = int((keep & tied & ~boundary & (size > 0)).sum())
    return np.where((moving & ~cut)[:, None], points, suspect.points), cut, altered & boundary[part], left


def _few(intact: IntArray) -> IntArray:
    return intact[:: max(len(intact) // MOST_JUDGES, 1)]


def _turned(
    points: FloatArray,
    faces: IntArray,
    moving: NDArray[np.bool_],
    index: SurfaceIndex,
    mini: tuple[FloatArray, IntArray],
) -> FloatArray:
    """Return (p,): the share of the faces at each moving point that face away from the miniature."""
    some = np.flatnonzero(moving[faces].any(axis=1))
    if not len(some):
        return np.zeros(len(points))
    nearest = index.nearest(points[faces[some]].mean(axis=1)).faces
    away = np.einsum("ij,ij->i", area_vectors(points, faces[some]), area_vectors(*mini)[nearest]) < 0.0
    total = np.bincount(faces[some].ravel(), minlength=len(points))
    turned = np.bincount(faces[some].ravel(), np.repeat(away, 3), len(points))
    return np.asarray(turned / np.maximum(total, 1))


def _result(suspect: Surface, points: FloatArray, faces: IntArray, *, old: int, left: int) -> Recovered:
    """Return the surface without points that lost their faces; the first `old` faces are those of the suspect."""
    before = len(suspect.points)
    kept = np.arange(len(points)) < before  # loose points stay
    kept[suspect.faces] = False
    kept[faces] = True
    origin = np.where(np.arange(len(points)) < before, np.arange(len(points)), -1)[kept]
    places = points[kept]
    moved = np.zeros(len(places), bool)
    there = origin >= 0
    moved[there] = (places[there] != suspect.points[origin[there]]).any(axis=1)
    return Recovered(
        points=places,
        faces=(np.cumsum(kept) - 1)[faces],
        origin=origin,
        moved=moved,
        added=np.arange(len(faces)) >= old,
        left=left,
    )

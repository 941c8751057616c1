"""The surface that carries a mark: each mesh of a scene once, however often it is shown (docs/decisions/0017)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from meshmark.geometry.shown import Shown
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.weld import weld
from meshmark.mesh import IntArray, Mesh
from meshmark.scene.distinct import Distinct, distinct, scene_of

if TYPE_CHECKING:
    from meshmark.geometry.affine import Affine
    from meshmark.geometry.copies import Copies

__all__ = [
    "Unfolded",
    "marked_surface",
    "mirrored",
    "once_each",
    "only_repeated",
    "surfaces_to_read",
    "unfolded",
]

# A copy that differs by this share of the model was changed, or its original was; at most this number of copies is
# tried in its place.
_CHANGED, _EXCHANGED = 1e-3, 2
# Number of faces of a copy that show its orientation.
_FACES = 200


@dataclass(frozen=True, eq=False, kw_only=True)
class Unfolded(Shown):
    """A surface with copies whose every copy was moved to the place of its original.

    place: (p,) the number of the map, in `maps`, that takes each point to its place in the scene.
    """

    place: IntArray
    maps: tuple[Affine, ...]


def marked_surface(mesh: Mesh) -> Surface:
    """Return the welded surface that an embedding into this mesh changes.

    That is one showing of each mesh where the mesh's file shows one several times; each vertex of the scene belongs
    to the point that it is an image of.
    """
    once = distinct(mesh)
    if once is None:
        return surface_of(mesh)
    surface = shown(surface_of(once.mesh), once)
    return replace(surface, point_of_vertex=surface.point_of_vertex[once.row])


def surfaces_to_read(mesh: Mesh, *, cut: bool = False) -> Iterator[Surface]:
    """Yield the surfaces that may carry the mark of a suspect, likeliest first.

    Where its file says what are copies of one mesh, first without these; where it does not, last without those
    that look like it. Next to each stands the part of it that is shown more than once: what stands around copies
    may be too large for them. cut: see `repeated`.
    """
    first = marked_surface(mesh)
    yield first
    if isinstance(first, Shown):
        yield from only_repeated(first)
        yield surface_of(mesh)
        return
    scene = scene_of(mesh)
    if scene is not None:
        yield from only_repeated(shown(first, scene))
        return
    from meshmark.scene.copies_by_shape import repeated

    for copies in repeated(mesh, cut=cut):
        surface = once_each(mesh, copies)
        yield surface
        yield from only_repeated(surface)
        yield from _exchanged(unfolded(mesh, copies))


def _exchanged(surface: Unfolded) -> Iterator[Surface]:
    """Yield the surface without copies but one, in place of its original, where one of the two was changed."""
    off = np.linalg.norm(surface.points - surface.points[surface.original], axis=1)
    far = off > _CHANGED * float(np.ptp(surface.points, axis=0).max())
    for number in np.unique(surface.place[far])[:_EXCHANGED]:
        gone = np.zeros(len(off), bool)
        gone[surface.original[surface.place == number]] = True
        kept = np.where(surface.place == 0, ~gone, surface.place == number)
        faces = surface.faces[kept[surface.faces].all(axis=1)]
        yield Surface(points=surface.points, faces=faces, point_of_vertex=surface.point_of_vertex)


def only_repeated(surface: Shown) -> Iterator[Shown]:
    """Yield the part of a surface that is shown more than once, unless that is all of it."""
    faces = surface.faces[(surface.times > 1)[surface.faces].all(axis=1)]
    if 0 < len(faces) < len(surface.faces):
        yield replace(surface, faces=faces)


def shown(surface: Surface, scene: Distinct) -> Shown:
    """Return the surface of `scene.mesh` with how often the scene shows each point."""
    return Shown(
        points=surface.points,
        faces=surface.faces,
        point_of_vertex=surface.point_of_vertex,
        times=scene.shown(surface),
        original=np.arange(len(surface.points)),
    )


def once_each(mesh: Mesh, copies: Copies) -> Shown:
    """Return the surface of a mesh without these copies."""
    own = copies.place == 0
    row = np.cumsum(own) - 1
    faces = mesh.faces[own[mesh.faces].all(axis=1)]
    welded = weld(Mesh(mesh.vertices[own], row[faces]))
    point = welded.point_of_vertex[row[copies.original]]
    pairs = np.unique(copies.place * len(welded.points) + point)
    times = np.bincount(pairs % len(welded.points), minlength=len(welded.points))
    return Shown(
        points=welded.points,
        faces=welded.faces,
        point_of_vertex=point,
        times=times,
        original=np.arange(len(welded.points)),
    )


def unfolded(mesh: Mesh, copies: Copies) -> Unfolded:
    """Return the surface of a mesh with each copy in the place of its original; copies stay parts of their own."""
    welded = surface_of(mesh)
    keys = copies.place * len(welded.points) + welded.point_of_vertex
    _, first, point = np.unique(keys, return_index=True, return_inverse=True)
    points, place = mesh.vertices[first].copy(), copies.place[first]
    for number, affine in enumerate(copies.maps):
        if number:
            points[place == number] = affine.inverse()(points[place == number])
    a, b, c = (corners := point[mesh.faces]).T
    faces = corners[(a != b) & (b != c) & (c != a)]
    times = np.ones(len(points), np.int64)
    original = point[copies.original[first]]
    turned = [number for number in range(1, len(copies.maps)) if _is_turned(faces, original, place, number)]
    faces = np.where(np.isin(place[faces[:, :1]], turned), faces[:, ::-1], faces)
    return Unfolded(
        points=points,
        faces=faces,
        point_of_vertex=point,
        times=times,
        original=original,
        place=place,
        maps=copies.maps,
    )


def mirrored(surface: Unfolded) -> Iterator[Unfolded]:
    """Yield the mirror image of a surface with mirrored copies: these may be the ones that were marked."""
    if any(np.linalg.det(affine.linear) < 0.0 for affine in surface.maps):
        yield replace(surface, points=surface.points * [-1.0, 1.0, 1.0])


def _is_turned(faces: IntArray, original: IntArray, place: IntArray, number: int) -> bool:
    """Return whether the faces of a copy turn the other way than the original's, as some tools turn mirrored ones.

    number: of the copy's place.
    """
    own = original[faces[place[faces[:, 0]] == number][:_FACES]]
    there = faces[place[faces[:, 0]] == 0]
    keys = {tuple(np.roll(face, -int(face.argmin()))) for face in there[np.isin(there, own).all(axis=1)]}
    plain = sum(tuple(np.roll(face, -int(face.argmin()))) in keys for face in own)
    back = sum(tuple(np.roll(face, -int(face.argmin()))) in keys for face in own[:, ::-1])
    return back > plain

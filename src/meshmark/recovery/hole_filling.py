"""Holes are filled with the miniature's faces, sewn to their holes so that what was closed is closed again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from meshmark.geometry.areas import area_vectors, vertex_normals
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.components import connected_components
from meshmark.geometry.kd_tree import kd_tree
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.borders import border_edges, fan, loops, strip
from meshmark.recovery.long_edges import split_long_edges

__all__ = ["Filled", "fill_holes"]

# Faces of the filling are this much longer than those around the hole, and keep this far from its boundary.
LONGER, GAP = 1.5, 0.6
# The boundary of a hole and that of a filling are sewn where they are this near, in edges of the hole.
REACH = 8.0
# Missing parts below this share of the largest one's area are no parts.
SMALLEST_PART = 0.02
# The boundary of a hole is one of the miniature's own where it lies within this many of its edges of it.
OWN_BORDER = 3.0
# What lies across a thin sheet from the rest faces away from it.
FACING, AWAY = -0.2, -0.5
# Beyond this many times the usual distance the miniature has something that the rest has not.
FAR = 6.0


@dataclass(frozen=True, eq=False)
class Filled:
    """points (q, 3), the first p as before; faces (m, 3), the first as before, then the filling's."""

    points: FloatArray
    faces: IntArray


def fill_holes(
    points: FloatArray,
    faces: IntArray,
    touched: NDArray[np.bool_],
    opened: NDArray[np.bool_],
    mini: tuple[FloatArray, IntArray],
) -> Filled:
    """Fill the holes of a surface whose boundaries are mostly `touched` (p,), as the miniature has it.

    mini: points and faces in the same coordinates. Holes that the miniature has, too, stay; one for which it has no
    fitting part is closed by a fan where its boundary was `opened` (p,) by a cut.
    """
    edges = border_edges(faces)
    holes = [hole[::-1] for hole in loops(edges) if touched[hole].mean() > 0.5]
    if not holes:
        return Filled(points, faces)
    ends = np.concatenate([np.stack([hole, np.roll(hole, -1)], axis=1) for hole in holes])
    size = float(np.sqrt(((points[ends[:, 0]] - points[ends[:, 1]]) ** 2).sum(axis=1).mean()))
    fine = split_long_edges(*mini, LONGER * size)
    surface = _Holed(points=points, faces=faces, border=edges, holes=ends)
    patch = _missing(surface, fine, GAP * size)
    new = _Sewing(points, faces, fine[0], patch)
    borders = loops(border_edges(patch)) if len(patch) else []
    pairs = _pairs(points, holes, fine[0], borders, REACH * size)
    for one, other in pairs:
        new.sew(holes[one], borders[other])
    own = border_edges(mini[1])
    for number in sorted(set(range(len(holes))) - {one for one, _ in pairs}):
        hole = holes[number]
        if opened[hole].mean() > 0.5 and not _is_own(points[hole], mini[0], own, OWN_BORDER * size):
            new.close(hole)
    for number in sorted(set(range(len(borders))) - {other for _, other in pairs}):
        if not _is_own(fine[0][borders[number]], mini[0], own, 0.1 * size):
            new.close(len(points) + borders[number][::-1])
    return new.result()


@dataclass(frozen=True, eq=False, kw_only=True)
class _Holed:
    """A surface, its border edges (b, 2), and those (h, 2) around the holes to be filled."""

    points: FloatArray
    faces: IntArray
    border: IntArray
    holes: IntArray


def _missing(surface: _Holed, fine: tuple[FloatArray, IntArray], gap: float) -> IntArray:
    """Return the miniature's faces that nothing is left of: their nearest point of the surface is on its border."""
    points, faces, holes = surface.points, surface.faces, surface.holes
    nearest = SurfaceIndex(points, faces).nearest(fine[0])
    on_border = np.zeros(len(points), bool)
    on_border[surface.border] = True
    corners = faces[nearest.faces]
    at_border = ((nearest.weights < 1e-6) | on_border[corners]).all(axis=1) & (nearest.weights < 1e-6).any(
        axis=1
    )
    vectors = area_vectors(points, faces)[nearest.faces]
    vectors /= np.maximum(np.sqrt((vectors**2).sum(axis=1)), 1e-300)[:, None]
    facing = np.einsum("ij,ij->i", vectors, vertex_normals(*fine))
    far = nearest.distances > FAR * float(np.median(nearest.distances))
    lost = (at_border & (facing > FACING)) | (facing < AWAY) | far
    tree = kd_tree(np.concatenate([points[holes[:, 0]], points[holes].mean(axis=1)]))
    lost &= tree.query(fine[0])[0] > gap
    part = fine[1][lost[fine[1]].all(axis=1)]
    return _simple(_large(part, fine[0]))


def _large(part: IntArray, places: FloatArray) -> IntArray:
    """Return the connected parts that are not tiny beside the largest: those are chance."""
    if not len(part):
        return part
    count = len(places)
    graph = coo_array((np.ones(part.size), (part.ravel(), part[:, [1, 2, 0]].ravel())), shape=(count, count))
    label = connected_components(graph)[1][part[:, 0]]
    area = np.bincount(label, np.sqrt((area_vectors(places, part) ** 2).sum(axis=1)))
    return np.asarray(part[(area > SMALLEST_PART * area.max())[label]])


def _simple(part: IntArray) -> IntArray:
    """Return the faces without those at points where the border meets itself."""
    while len(part):
        edges = border_edges(part)
        times = np.bincount(edges[:, 0], minlength=int(part.max()) + 1)
        bad = times > 1
        if not bad.any():
            break
        part = part[~bad[part].any(axis=1)]
    return part


def _pairs(
    points: FloatArray, holes: list[IntArray], places: FloatArray, borders: list[IntArray], reach: float
) -> list[tuple[int, int]]:
    """Return which hole is sewn to which border: each to its nearest, each once, none farther than `reach`."""
    choices = []
    for number, hole in enumerate(holes):
        tree = kd_tree(points[hole])
        for other, border in enumerate(borders):
            there = np.mean(tree.query(places[border])[0])
            back = np.mean(kd_tree(places[border]).query(points[hole])[0])
            choices.append((float(there + back), number, other))
    pairs: list[tuple[int, int]] = []
    for off, hole_number, border_number in sorted(choices):
        if 0.5 * off < reach and all(hole_number != a and border_number != b for a, b in pairs):
            pairs.append((hole_number, border_number))
    return pairs


def _is_own(walk: FloatArray, places: FloatArray, own: IntArray, reach: float) -> bool:
    """Whether a walk (k, 3) runs along the border of the miniature itself."""
    if not len(own):
        return False
    start, end = places[own[:, 0]], places[own[:, 1]]
    shares = np.linspace(0.0, 1.0, 33)[:, None, None]
    tree = kd_tree((start + shares * (end - start)).reshape(-1, 3))
    return float(np.median(tree.query(walk)[0])) < reach


class _Sewing:
    """The surface, the miniature's points behind its own, and faces as they come."""

    def __init__(self, points: FloatArray, faces: IntArray, places: FloatArray, patch: IntArray) -> None:
        self.count = len(points)
        self.points = np.concatenate([points, places])
        self.faces = [faces, patch + self.count]
        self.extra: list[FloatArray] = []

    def sew(self, hole: IntArray, border: IntArray) -> None:
        """Add the strip between a hole, walked as the filling has it, and the border of a part."""
        one, other = self.points[hole], self.points[self.count + border]
        distance, nearest = kd_tree(other).query(one)
        start = int(np.argmin(distance))
        hole, border = np.roll(hole, -start), np.roll(border, -int(np.asarray(nearest)[start]))
        made = strip(self.points[hole], self.points[self.count + border], True)
        self.faces.append(np.concatenate([hole, self.count + border])[made])

    def close(self, walk: IntArray) -> None:
        """Add a fan over a closed walk."""
        self.extra.append(self.points[walk].mean(axis=0))
        self.faces.append(fan(walk, len(self.points) + len(self.extra) - 1))

    def result(self) -> Filled:
        """Return the surface without points of the miniature that no face uses."""
        points = np.concatenate([self.points, np.reshape(self.extra, (-1, 3))])
        faces = np.concatenate(self.faces)
        kept = np.arange(len(points)) < self.count
        kept[faces] = True
        return Filled(points[kept], (np.cumsum(kept) - 1)[faces])

"""The file of a model whose surface was recovered: vertices that stayed keep their attributes and their order."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.copies_recovery import folded, scene_again
from meshmark.geometry.surface import Surface
from meshmark.io.derived import derived
from meshmark.io.file_precision import conform
from meshmark.mesh import IntArray, Mesh
from meshmark.recovery.repair import Recovered
from meshmark.recovery.same_points import corner_sets
from meshmark.scene.distinct import distinct
from meshmark.scene.surfaces import Unfolded

__all__ = ["RecoveredFile", "in_file"]


@dataclass(frozen=True, eq=False, kw_only=True)
class RecoveredFile:
    """mesh: as its file can hold it; moved: how many vertices lie elsewhere; removed: how many are gone."""

    mesh: Mesh
    moved: int
    removed: int


def in_file(mesh: Mesh, surface: Surface, made: Recovered) -> RecoveredFile:
    """Return the file of a mesh with what was recovered of its `surface`, a marked or an unfolded one."""
    once = distinct(mesh)
    if once is not None:
        surface = replace(surface, point_of_vertex=surface.point_of_vertex[once.rows])
        whole, moved, removed, origin = _of_file(once.mesh, surface, made)
        return RecoveredFile(mesh=scene_again(once, whole, origin), moved=moved, removed=removed)
    if isinstance(surface, Unfolded):
        made = folded(surface, made)
    whole, moved, removed, _ = _of_file(mesh, surface, made)
    return RecoveredFile(mesh=whole, moved=moved, removed=removed)


def _of_file(mesh: Mesh, surface: Surface, made: Recovered) -> tuple[Mesh, int, int, IntArray]:
    """Return the recovered mesh with the file's own vertices, how many moved, how many went, and which each was."""
    there = made.origin >= 0
    number = np.full(len(surface.points), -1)
    number[made.origin[there]] = np.flatnonzero(there)
    at = number[surface.point_of_vertex]
    moved = (at >= 0) & made.moved[at]
    vertices = np.where(moved[:, None], made.points[at], mesh.vertices)
    kept = _kept_faces(mesh.faces, surface, made)
    if kept.all() and not made.added.any():
        same = mesh.with_vertices(conform(mesh, vertices))
        return same, int(moved.sum()), 0, np.arange(len(vertices))
    used_before, used = np.zeros(len(vertices), bool), np.zeros(len(vertices), bool)
    used_before[mesh.faces] = True
    corners = _corners(surface, made, len(vertices))
    used[mesh.faces[kept]] = True
    used[corners[corners < len(vertices)]] = True
    stays = used | ~used_before
    rename = np.concatenate([np.cumsum(stays) - 1, stays.sum() + np.arange((~there).sum())])
    origin = np.concatenate([np.flatnonzero(stays), np.full(int((~there).sum()), -1)])
    whole = derived(
        mesh,
        np.concatenate([vertices[stays], made.points[~there]]),
        rename[np.concatenate([mesh.faces[kept], corners])],
        origin,
    )
    return whole, int((moved & stays).sum()), int((~stays).sum()), origin


def _kept_faces(faces: IntArray, surface: Surface, made: Recovered) -> NDArray[np.bool_]:
    """Return (m,): the faces of the file that are still there."""
    old = made.origin[made.faces[~made.added]]
    points = surface.point_of_vertex[faces]
    flat = (points == np.roll(points, 1, axis=1)).any(axis=1)
    there = np.isin(corner_sets(points), corner_sets(old))
    return np.asarray(there | (flat & np.isin(points, made.origin).all(axis=1)))


def _corners(surface: Surface, made: Recovered, count: int) -> IntArray:
    """Return (k, 3): the new faces in vertices of the file; the i-th new point has the number count + i."""
    names = np.empty(len(made.points), np.int64)
    new = made.origin < 0
    names[~new] = surface.vertex_of_point[made.origin[~new]]
    names[new] = count + np.arange(new.sum())
    return names[made.faces[made.added]]

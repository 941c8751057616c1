"""Recovery of a model's file: what was altered returns to the miniature that the intact part carries."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.copies_recovery import folded, scene_again
from meshmark.authentication.examination import Examination, examine
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.surface import Surface
from meshmark.io.derived import derived, losses
from meshmark.io.file_precision import conform
from meshmark.mesh import IntArray, Mesh
from meshmark.notebook import notebook_table
from meshmark.recovery.borders import border_edges
from meshmark.recovery.repair import Recovered
from meshmark.recovery.repair import recover as recover_surface
from meshmark.scene.distinct import distinct
from meshmark.scene.surfaces import Unfolded
from meshmark.threads import on_one_thread

__all__ = ["Recovery", "recover"]


_LEFT = "What differs by no more than the miniature itself is off is left as it is."
_CUT = "Altered parts that could not be moved back were cut out, and nothing takes their place."
_APART = (
    "What was altered is a connected component of its own, or part of one, which cannot be moved back onto the "
    "miniature: it is left as it is."
)
_OPEN = "A hole is left open that meets a border of the model's own, or for which the miniature has nothing."


@dataclass(frozen=True, eq=False, kw_only=True)
class Recovery:
    """What came of a recovery.

    mesh: the model with its altered parts as the miniature has them, as it is where nothing was altered; None
    where that cannot be done. altered_area_fraction: of the suspect's surface, 0 to 1. vertices_moved: of those
    that stay; vertices_removed, faces_added. lost: names of what the file held that one with other faces cannot.
    advice: one sentence for the reader.
    """

    mesh: Mesh | None
    altered_area_fraction: float
    vertices_moved: int
    vertices_removed: int
    faces_added: int
    advice: str
    seconds: float
    lost: tuple[str, ...] = ()

    def _repr_html_(self) -> str:
        return notebook_table(
            "Not recovered" if self.mesh is None else "Recovered",
            [
                ("What was done", self.advice),
                ("Altered", f"{100 * self.altered_area_fraction:.2g} % of the surface"),
                ("Moved back", f"{self.vertices_moved:,} vertices" if self.vertices_moved else ""),
                ("Cut out", f"{self.vertices_removed:,} vertices" if self.vertices_removed else ""),
                ("Added", f"{self.faces_added:,} faces" if self.faces_added else ""),
                ("Not kept", ", ".join(self.lost)),
            ],
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        names = (
            "altered_area_fraction",
            "vertices_moved",
            "vertices_removed",
            "faces_added",
            "lost",
            "advice",
            "seconds",
        )
        return {"recovered": self.mesh is not None, **{name: getattr(self, name) for name in names}}


@on_one_thread
def recover(mesh: Mesh, key: Key, *, reference: Certificate | Mesh | None = None) -> Recovery:
    """Return the mesh with altered parts brought back: moved ones return, foreign ones go, holes are filled.

    Everything else stays bit by bit, with its attributes.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
        That it was marked with.
    reference : Certificate or Mesh, optional
        The certificate or the unmarked original, which helps to find the mark.

    Returns
    -------
    Recovery

    Raises
    ------
    InputError
        The mesh has no surface, or the certificate of this key was edited.
    """
    start = perf_counter()
    found = examine(mesh, key, reference)
    areas = found.surface.point_areas
    share = float(areas[found.altered].sum() / areas.sum())
    missing = (found.points_missing or 0) > 0
    if found.marked and not found.altered.any() and not missing:
        return Recovery(
            mesh=mesh,
            altered_area_fraction=0.0,
            vertices_moved=0,
            vertices_removed=0,
            faces_added=0,
            advice="Nothing was altered.",
            seconds=perf_counter() - start,
        )
    payload = found.payload
    if payload is None or payload.kind != "miniature":
        return _unrecovered(share, _why_not(found), start)
    try:
        made = recover_surface(found.surface, found.altered, payload.content, missing=missing)
    except InputError as error:
        return _unrecovered(share, f"It cannot be recovered: {error}.", start)
    once = distinct(mesh)
    if once is not None:
        surface = replace(found.surface, point_of_vertex=found.surface.point_of_vertex[once.rows])
        whole, moved, removed, origin = _of_file(once.mesh, surface, made)
        whole = scene_again(once, whole, origin)
    elif isinstance(found.surface, Unfolded):
        whole, moved, removed, _ = _of_file(mesh, found.surface, folded(found.surface, made))
    else:
        whole, moved, removed, _ = _of_file(mesh, found.surface, made)
    added = int(made.added.sum())
    # Points that nobody added are not to go without anything in their place.
    only_cut = removed > 0 and not (moved or added) and found.points_missing == 0
    if only_cut or not (moved or removed or added):
        advice = "What was altered is less than the miniature tells, or out of its reach."
        if not found.altered.any():
            advice = "Whole parts are missing, which the miniature does not have; they are not brought back."
        if _left_open(found, made):
            advice = f"Nothing was brought back. {_OPEN}"
        if only_cut:
            advice = _APART
        return _unrecovered(share, advice, start)
    advice = "The altered parts are back as the miniature has them."
    if not found.altered.any():
        advice = "The missing parts are back as the miniature has them."
    if removed and not added and found.points_missing == 0:
        advice += f" {_CUT}"
    if _left_open(found, made):
        advice += f" {_OPEN}"
    if made.left:
        advice += f" {_LEFT}"
    lost = losses(whole)
    if lost:
        advice += f" Its file cannot keep with other faces: {', '.join(lost)}."
    return Recovery(
        mesh=whole,
        altered_area_fraction=share,
        vertices_moved=moved,
        vertices_removed=removed,
        faces_added=added,
        advice=advice,
        seconds=perf_counter() - start,
        lost=lost,
    )


def _unrecovered(share: float, advice: str, start: float) -> Recovery:
    """Return that nothing was brought back; share: altered, of the surface; start: of the work, in seconds."""
    return Recovery(
        mesh=None,
        altered_area_fraction=share,
        vertices_moved=0,
        vertices_removed=0,
        faces_added=0,
        advice=advice,
        seconds=perf_counter() - start,
    )


def _why_not(found: Examination) -> str:
    if not found.marked:
        return "No mark of authentication of this key was found, so there is nothing to recover from."
    if found.payload is None:
        return "Too little is intact to read the payload."
    return f"The model carries no miniature of itself; its payload: {found.payload.kind}."


def _left_open(found: Examination, made: Recovered) -> bool:
    """Return whether a boundary that an edit made is still a border."""
    new_boundary = np.append(found.checks.new_boundary, False)[
        made.origin
    ]  # new points, -1, were not new_boundary
    ends = border_edges(made.faces)
    return bool(new_boundary[ends].all(axis=1).any())


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
    there = np.isin(_triples(points), _triples(old))
    return np.asarray(there | (flat & np.isin(points, made.origin).all(axis=1)))


def _triples(faces: IntArray) -> NDArray[np.void]:
    """Return (m,) values that are equal for faces of the same three points."""
    rows = np.ascontiguousarray(np.sort(faces, axis=1))
    return rows.view([("a", np.int64), ("b", np.int64), ("c", np.int64)]).ravel()


def _corners(surface: Surface, made: Recovered, count: int) -> IntArray:
    """Return (k, 3): the new faces in vertices of the file; the i-th new point has the number count + i."""
    names = np.empty(len(made.points), np.int64)
    new = made.origin < 0
    names[~new] = surface.vertex_of_point[made.origin[~new]]
    names[new] = count + np.arange(new.sum())
    return names[made.faces[made.added]]

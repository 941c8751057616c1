"""Recovery of a model's file: what was altered returns to the miniature that the intact part carries."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from meshmark.authentication.examination import Examination, examine
from meshmark.authentication.recovered_file import in_file
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.io.derived import losses
from meshmark.mesh import Mesh
from meshmark.notebook import notebook_table
from meshmark.recovery.borders import border_edges
from meshmark.recovery.repair import Recovered
from meshmark.recovery.repair import recover as recover_surface
from meshmark.threads import on_one_thread

__all__ = ["Recovery", "recover_by_miniature", "unrecovered"]


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

    mesh: the model with its altered parts brought back, as it is where nothing was altered; None where that cannot
    be done. altered_area_fraction: of the suspect's surface, 0 to 1. vertices_moved: of those that stay;
    vertices_removed, faces_added. lost: names of what the file held that one with other faces cannot.
    restored_from: "miniature", "marked_copy" (or one made again from the original) or "original" (unmarked); None
    where nothing was brought back. intact_rms_over_diagonal: how far intact vertices lie from the copy made again.
    advice: one sentence for the reader.
    """

    mesh: Mesh | None
    altered_area_fraction: float = 0.0
    vertices_moved: int = 0
    vertices_removed: int = 0
    faces_added: int = 0
    advice: str
    seconds: float
    lost: tuple[str, ...] = ()
    restored_from: str | None = None
    intact_rms_over_diagonal: float | None = None

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
            "restored_from",
            "intact_rms_over_diagonal",
            "advice",
            "seconds",
        )
        return {"recovered": self.mesh is not None, **{name: getattr(self, name) for name in names}}


@on_one_thread
def recover_by_miniature(mesh: Mesh, key: Key, *, reference: Certificate | Mesh | None = None) -> Recovery:
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
        return Recovery(mesh=mesh, advice="Nothing was altered.", seconds=perf_counter() - start)
    payload = found.payload
    if payload is None or payload.kind != "miniature":
        return unrecovered(share, _why_not(found), start)
    try:
        made = recover_surface(found.surface, found.altered, payload.content, missing=missing)
    except InputError as error:
        return unrecovered(share, f"It cannot be recovered: {error}.", start)
    file = in_file(mesh, found.surface, made)
    whole, moved, removed = file.mesh, file.moved, file.removed
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
        return unrecovered(share, advice, start)
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
        restored_from="miniature",
    )


def unrecovered(share: float, advice: str, start: float) -> Recovery:
    """Return that nothing was brought back, and why; share: altered, of the surface; start: in seconds."""
    return Recovery(mesh=None, altered_area_fraction=share, advice=advice, seconds=perf_counter() - start)


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

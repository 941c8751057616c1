"""Cut and paste: a part of another marked model replaces a part of this one (docs/design.md, section 10)."""

from __future__ import annotations

from typing import cast

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.crop import without
from meshmark.attacks.local_patch import Patch, draw_patch
from meshmark.attacks.moved_vertices import moved
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, Mesh

__all__ = ["paste"]


def paste(mesh: Mesh, strength: float, rng: np.random.Generator, given: Given) -> Attacked:
    """Replace the share `strength` of the points, around a random one, by a part of `given.donor`.

    A donor with the same vertices and faces (the same model with another mark) gives the positions of the same
    vertices, wherever it lies; `altered` marks those that this moves. Of any other donor the same share, around
    a random point of its own, is cut out, turned and scaled to the hole, and laid in without sewing; `altered`
    marks the new vertices and the boundary of the hole.
    Raises `InputError` for a share of 1 or more, a model without faces, and where either part has too few.
    """
    donor = cast(Mesh, given.donor)  # `Attack.apply` has checked that there is one
    hole = draw_patch(mesh, strength, rng)
    if donor.vertices.shape == mesh.vertices.shape and np.array_equal(donor.faces, mesh.faces):
        inside = hole.holds[hole.welded.point_of_vertex]
        result = moved(mesh, np.where(inside[:, None], donor.vertices, mesh.vertices))
        altered = (result.mesh.vertices != mesh.vertices).any(axis=1)
        return Attacked(mesh=result.mesh, origin=result.origin, altered=altered)
    part = draw_patch(donor, strength, rng)
    piece = without(donor, ~part.holds[part.welded.point_of_vertex]).mesh
    return _joined(hole, Mesh(_laid_in(piece.vertices, part, hole), piece.faces), strength)


def _laid_in(points: FloatArray, part: Patch, hole: Patch) -> FloatArray:
    """Move points, (n, 3), from where a part was cut out to where a hole is."""
    start, end = part.points.mean(axis=0), hole.points.mean(axis=0)
    turn = _turn(part.normal, hole.normal)
    return np.asarray(turn.apply(points - start) * (hole.radius / part.radius) + end)


def _joined(hole: Patch, piece: Mesh, share: float) -> Attacked:
    """Put `piece` where the members of `hole` are taken out."""
    mesh = hole.mesh
    gone = hole.holds[hole.welded.point_of_vertex]
    rest = without(mesh, gone)
    if not len(rest.mesh.faces) or not len(piece.faces):
        which, wanted = ("model", "smaller") if len(piece.faces) else ("donor's part", "larger")
        raise InputError(
            f"pasting {share:g} of the points leaves no face of the {which}, expected a {wanted} share"
        )
    boundary = np.zeros(len(hole.welded.points), bool)  # by points, so that both sides of a seam are marked
    boundary[hole.welded.point_of_vertex[mesh.faces[gone[mesh.faces].any(axis=1)]]] = True
    count, new = len(rest.mesh.vertices), len(piece.vertices)
    return Attacked(
        mesh=Mesh(
            np.concatenate([rest.mesh.vertices, piece.vertices]),
            np.concatenate([rest.mesh.faces, piece.faces + count]),
        ),
        origin=np.concatenate([np.flatnonzero(~gone), np.full(new, -1)]),
        altered=np.concatenate([boundary[hole.welded.point_of_vertex[~gone]], np.ones(new, bool)]),
    )


def _turn(start: FloatArray, end: FloatArray) -> Rotation:
    """Return the shortest rotation from one unit vector to another; from opposite ones, half a turn."""
    axis = np.cross(start, end)
    length = float(np.linalg.norm(axis))
    angle = np.arctan2(length, start @ end)
    if length < 1e-12:  # about any axis at right angles
        axis = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        length = float(np.linalg.norm(axis))
    return Rotation.from_rotvec(axis / length * angle)

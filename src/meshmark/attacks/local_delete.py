"""A part of the model deleted, which leaves a hole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_patch import draw_patch
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["delete_part", "without_loose"]


def delete_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Delete the share `strength` of the vertices, around a random one, with all faces there.

    `altered` marks the vertices on the boundary of the hole, none where whole parts went; vertices whose last face
    went are gone, too. Raises `InputError` for a share of 1 or more, a mesh without faces,
    and where none would be left.
    """
    patch = draw_patch(mesh, strength, rng)
    gone = patch.holds[patch.welded.point_of_vertex][mesh.faces].any(axis=1)
    if gone.all():
        raise InputError(f"deleting {strength:g} of the vertices leaves no face, expected a smaller share")
    boundary = np.zeros(len(patch.welded.points), bool)  # by points, so that both sides of a seam are marked
    boundary[patch.welded.point_of_vertex[mesh.faces[gone]]] = True
    altered = boundary[patch.welded.point_of_vertex]
    lost = np.zeros(len(mesh.vertices), bool)
    lost[mesh.faces[gone]] = True
    return without_loose(mesh.vertices, mesh.faces[~gone], np.arange(len(mesh.vertices)), altered, lost)


def without_loose(
    vertices: FloatArray,
    faces: IntArray,
    origin: IntArray,
    altered: NDArray[np.bool_],
    doubtful: NDArray[np.bool_],
) -> Attacked:
    """Return these as an attacked mesh, less those `doubtful` (n,) vertices that no face uses."""
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    kept = used | ~doubtful
    number = np.cumsum(kept) - 1
    return Attacked(mesh=Mesh(vertices[kept], number[faces]), origin=origin[kept], altered=altered[kept])

"""Recovery of a model with altered parts from its miniature (DESIGN section 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.miniature import read_miniature
from meshmark.recovery.moving import draw_back
from meshmark.recovery.placing import place_miniature

__all__ = ["Recovered", "recover"]


@dataclass(frozen=True, eq=False)
class Recovered:
    """A recovered surface of q points.

    points: (q, 3); faces: (m, 3). origin: (q,) the point of the suspect that each one was, -1 for one that is new.
    moved: (q,) whether a point that was there lies elsewhere; added: (m,) whether a face is new.
    """

    points: FloatArray
    faces: IntArray
    origin: IntArray
    moved: NDArray[np.bool_]
    added: NDArray[np.bool_]


def recover(suspect: Welded, altered: NDArray[np.bool_], miniature: bytes) -> Recovered:
    """Return the suspect with its altered parts as the miniature has them; what is not altered stays bit by bit.

    altered: (p,) of the suspect's points. Raises `InputError` where they do not match the suspect, and where the
    miniature is damaged or does not fit the rest.
    """
    if altered.shape != (len(suspect.points),):
        raise InputError(f"{len(altered)} points are called altered or not, expected {len(suspect.points)}")
    places, mini_faces = read_miniature(miniature)
    used = np.zeros(len(suspect.points), bool)
    used[suspect.faces] = True
    pose = place_miniature(
        (places, mini_faces), suspect.points, suspect.faces, np.flatnonzero(used & ~altered)
    )
    points = draw_back(suspect.points, suspect.faces, altered, (pose(places), mini_faces))
    moved = (points != suspect.points).any(axis=1)
    return Recovered(
        points, suspect.faces, np.arange(len(points)), moved, np.zeros(len(suspect.faces), dtype=bool)
    )

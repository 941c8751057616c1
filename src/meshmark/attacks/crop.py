"""Cropping by a plane (docs/design.md, section 10)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.attack import Attacked, Given
from meshmark.errors import InputError
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh

__all__ = ["crop", "without"]


def crop(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Remove the vertices beyond a plane, and every face that has one of them; strength is their share.

    The plane is at right angles to a seeded direction, uniform on the sphere. As many vertices go as the share
    says, rounded; coincident ones go together, so that with seams the count is the nearest possible. At least
    one goes. Raises `InputError` where no vertex, or none of the faces there were, would be left.
    """
    direction = rng.normal(size=3)
    welded = weld(mesh)
    gone = _farthest(welded, welded.points @ (direction / np.linalg.norm(direction)), strength)
    left = without(mesh, gone)
    if not len(left.mesh.vertices) or (len(mesh.faces) and not len(left.mesh.faces)):
        raise InputError(f"cropping {strength:g} of the vertices leaves no surface, expected a smaller share")
    return left


def without(mesh: Mesh, gone: NDArray[np.bool_]) -> Attacked:
    """Remove the vertices marked in `gone`, (n,), and every face that has one of them.

    The others keep their order; one that loses all its faces stays.
    """
    number = np.cumsum(~gone) - 1
    faces = mesh.faces[~gone[mesh.faces].any(axis=1)]
    return Attacked(mesh=Mesh(mesh.vertices[~gone], number[faces]), origin=np.flatnonzero(~gone))


def _farthest(welded: Surface, height: FloatArray, share: float) -> NDArray[np.bool_]:
    """Return (n,): the share of the vertices whose points are highest, whole points and at least one."""
    order = np.argsort(-height, kind="stable")
    count = np.cumsum(np.bincount(welded.point_of_vertex)[order])
    last = int(np.argmin(np.abs(count - round(share * len(welded.point_of_vertex)))))
    gone = np.zeros(len(order), bool)
    gone[order[: last + 1]] = True
    return gone[welded.point_of_vertex]

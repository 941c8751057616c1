"""A piece of its own put onto the model, as when a horn or a button is added."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_patch import draw_patch, unit
from meshmark.errors import InputError
from meshmark.geometry.areas import face_areas
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["add_part"]

FEWEST = 12
SUNK = 0.5
"""The middle of the new piece lies this many of its radii above the surface, so that the two overlap."""
UNEVEN = 0.1
"""The new piece is out of round by this share of its radius."""


def add_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Add a closed, roundish piece with the share `strength` of the model's points and area, at a random point.

    It has at least twelve points and is not sewn on, as pieces from another program are not. `altered` marks its
    vertices; they have no origin. All vertices of the model stay bit by bit. Raises `InputError` for a share of 1
    or more, a mesh without faces, and one without area.
    """
    patch = draw_patch(mesh, strength, rng)
    size = float(np.ptp(patch.welded.points[patch.welded.faces.ravel()], axis=0).max()) or 1.0
    area = float(face_areas(patch.welded.points / size, patch.welded.faces).sum())
    if area == 0.0:
        raise InputError("the model has no area, expected a surface to add a part to")
    radius = size * float(np.sqrt(strength * area / (4.0 * np.pi)))
    ball, faces = _ball(max(len(patch.members), FEWEST), rng)
    new = patch.points[0] + radius * (SUNK * patch.normal + ball)
    old = len(mesh.vertices)
    origin = np.concatenate([np.arange(old), np.full(len(new), -1)])
    whole = Mesh(np.concatenate([mesh.vertices, new]), np.concatenate([mesh.faces, faces + old]))
    return Attacked(mesh=whole, origin=origin, altered=origin < 0)


def _ball(count: int, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
    """Return `count` points (count, 3) on an uneven ball of radius about 1, turned at random, and its faces."""
    turn = Rotation.from_rotvec(rng.uniform(0.0, np.pi) * unit(rng))
    places = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * places / count, np.pi * (1.0 + 5.0**0.5) * places
    flat = np.sqrt(1.0 - height**2)
    sphere = np.stack([flat * np.cos(angle), flat * np.sin(angle), height], axis=1)
    faces = ConvexHull(sphere).simplices.astype(np.int64)
    corners = sphere[faces]
    outward = (
        np.einsum("fi,fi->f", np.cross(*np.diff(corners, axis=1).transpose(1, 0, 2)), corners[:, 0]) > 0.0
    )
    faces = np.where(outward[:, None], faces, faces[:, ::-1])
    wave = 2.0 * unit(rng)
    return turn.apply(
        sphere * (1.0 + UNEVEN * np.sin(sphere @ wave + rng.uniform(0.0, 2.0 * np.pi)))[:, None]
    ), faces

"""A part of the model turned and shifted, or scaled, a little, as when a pose or a proportion is changed."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_patch import Patch, draw_patch, unit
from meshmark.mesh import FloatArray, Mesh

__all__ = ["move_part", "scale_part"]

ANGLE = np.deg2rad(15.0)
SHIFT = 0.2
"""Shift over the radius of the part."""
FACTOR = 1.15
STIFF = 0.5
"""Up to this share of its radius the part moves as one; from there on it blends into the rest."""


def move_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Turn the share `strength` of the vertices, around a random one, by 15 degrees and shift it by 0.2 radii.

    Axis and direction are random. The inner half of the radius moves rigidly; outside, the motion fades. All
    other vertices stay bit by bit. Raises `InputError` for a share of 1 or more, and a mesh without faces.
    """
    patch = draw_patch(mesh, strength, rng)
    pivot = patch.points.mean(axis=0)
    turn = Rotation.from_rotvec(ANGLE * unit(rng))
    moved = turn.apply(patch.points - pivot) + pivot + SHIFT * patch.radius * unit(rng)
    return _blended(patch, moved)


def scale_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Make the share `strength` of the vertices, around a random one, 1.15 times as large.

    The middle of the part stays where it is. The inner half of the radius keeps its shape; outside, the change
    fades. All other vertices stay bit by bit. Raises `InputError` as `move_part` does.
    """
    patch = draw_patch(mesh, strength, rng)
    middle = patch.points.mean(axis=0)
    return _blended(patch, middle + FACTOR * (patch.points - middle))


def _blended(patch: Patch, moved: FloatArray) -> Attacked:
    """Move the inner part of a patch to `moved` (k, 3), the outer part less and less."""
    late = np.clip((patch.reach - STIFF) / (1.0 - STIFF), 0.0, 1.0)
    share = 1.0 - late**2 * (3.0 - 2.0 * late)
    return patch.moved_to(patch.points + share[:, None] * (moved - patch.points))

"""A bump raised or a dent pressed somewhere on the surface, as with a sculpting brush."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_patch import draw_patch
from meshmark.mesh import Mesh

__all__ = ["HEIGHT", "bump", "dent"]

HEIGHT = 0.3
"""Height of a bump over its radius."""


def bump(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Raise the share `strength` of the vertices, around a random one, by (1 - s^2)^2 times 0.3 radii.

    s is the distance along the surface from the centre over the radius; the direction is the mean normal. All other
    vertices stay bit by bit. Raises `InputError` for a share of 1 or more, and a mesh without faces.
    """
    return _relief(mesh, strength, rng, HEIGHT)


def dent(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Press what `bump` raises."""
    return _relief(mesh, strength, rng, -HEIGHT)


def _relief(mesh: Mesh, share: float, rng: np.random.Generator, height: float) -> Attacked:
    patch = draw_patch(mesh, share, rng)
    rise = height * patch.radius * (1.0 - patch.reach**2) ** 2
    return patch.moved_to(patch.points + rise[:, None] * patch.normal)

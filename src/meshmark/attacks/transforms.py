"""Linear changes of the whole model: similarity, stretching, mirroring."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.moved_vertices import centroid, moved
from meshmark.mesh import Mesh

__all__ = ["affine", "mirror", "similarity"]


def similarity(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Turn, scale and move the model; at strength 1 by any rotation, 0.1 to 10 times, up to 1 diagonal away.

    Below 1 the angle, the logarithm of the scale and the way on each axis are that share of what they would be.
    The rotation is uniform over all rotations, the logarithm of the scale and the way uniform in their ranges.
    """
    turn = strength * _any_rotation(rng).as_rotvec()
    scale = 10.0 ** (strength * rng.uniform(-1.0, 1.0))
    way = strength * rng.uniform(-1.0, 1.0, 3) * np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    middle = centroid(mesh)
    turned = (mesh.vertices - middle) @ Rotation.from_rotvec(turn).as_matrix().T
    return moved(mesh, turned * scale + middle + way)


def affine(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Stretch the model about its centroid by 1 + s, 1 and 1 - s along its coordinate axes, in a seeded order.

    Strength is s. An editor stretches along the axes of the file.
    """
    stretch = rng.permutation([1.0 + strength, 1.0, 1.0 - strength])
    middle = centroid(mesh)
    return moved(mesh, (mesh.vertices - middle) * stretch + middle)


def mirror(mesh: Mesh, _strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Mirror the model in the middle of its x axis, and turn its faces over so that the outside stays outside."""
    low, high = mesh.vertices[:, 0].min(), mesh.vertices[:, 0].max()
    vertices = mesh.vertices.copy()
    vertices[:, 0] = low + high - vertices[:, 0]
    return Attacked(mesh=Mesh(vertices, mesh.faces[:, [0, 2, 1]]), origin=np.arange(len(vertices)))


def _any_rotation(rng: np.random.Generator) -> Rotation:
    """Return a rotation uniform over all: a quaternion of normal numbers has no preferred direction."""
    return Rotation.from_quat(rng.normal(size=4))

"""The same surface under other vertex and face numbers."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.geometry.weld import weld as weld_points
from meshmark.mesh import Mesh

__all__ = ["shuffle", "unweld", "weld"]


def shuffle(mesh: Mesh, _strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Put vertices and faces into a random order, and let every face start at a random corner."""
    origin = rng.permutation(len(mesh.vertices))
    number = np.empty_like(origin)
    number[origin] = np.arange(len(origin))
    start = rng.integers(3, size=(len(mesh.faces), 1))
    turned = np.take_along_axis(mesh.faces, (start + np.arange(3)) % 3, axis=1)
    return Attacked(mesh=Mesh(mesh.vertices[origin], number[rng.permutation(turned)]), origin=origin)


def weld(mesh: Mesh, _strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Make coincident vertices one, and drop the faces that this leaves without three corners."""
    welded = weld_points(mesh)
    return Attacked(mesh=Mesh(welded.points, welded.faces), origin=welded.vertex_of_point)


def unweld(mesh: Mesh, _strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Give every corner of every face a vertex of its own; vertices without a face follow at the end."""
    lone = np.ones(len(mesh.vertices), bool)
    lone[mesh.faces] = False
    origin = np.concatenate([mesh.faces.ravel(), np.flatnonzero(lone)])
    return Attacked(
        mesh=Mesh(mesh.vertices[origin], np.arange(mesh.faces.size).reshape(-1, 3)), origin=origin
    )

"""Models for the tests of attacks."""

from __future__ import annotations

import numpy as np

from meshmark.attacks import Given
from meshmark.mesh import Mesh
from tests.shapes import pebble


def seamed(across: int = 24) -> Mesh:
    """A closed shape whose faces on the two sides of x = 0 have vertices of their own, as at a texture seam."""
    points, faces = pebble(across)
    right = points[faces].mean(axis=1)[:, 0] > 0.0
    shared = np.intersect1d(faces[right], faces[~right])
    copy_of = np.arange(len(points))
    copy_of[shared] = len(points) + np.arange(len(shared))
    faces = np.where(right[:, None], copy_of[faces], faces)
    return Mesh(np.concatenate([points, points[shared]]), faces)


def seam(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of vertices in one place: pairs (first, second), by comparison of all with all."""
    same = (mesh.vertices[:, None] == mesh.vertices[None]).all(axis=2)
    return np.nonzero(np.triu(same, 1))


def remarked(mesh: Mesh, seed: int) -> Mesh:
    """Stand-in for the same model with another mark: a little noise, alike on both sides of a seam."""
    _, number = np.unique(mesh.vertices, axis=0, return_inverse=True)
    noise = np.random.default_rng(seed).normal(0.0, 1e-3, (len(mesh.vertices), 3))
    return mesh.with_vertices(mesh.vertices + noise[number])


def given_for(mesh: Mesh) -> Given:
    """Everything an attacker may hold."""
    copies = tuple(remarked(mesh, seed) for seed in range(1, 5))
    return Given(copies=copies, donor=copies[0], embed=lambda own: remarked(own, 9))


def odd_strip(count: int = 5) -> Mesh:
    """An odd model: an open strip, a vertex that no face uses, and a face that names a vertex twice."""
    x = np.repeat(np.arange(count, dtype=float), 2)
    y = np.tile([0.0, 1.0], count)
    vertices = np.stack([x, y, 0.1 * x * y], axis=1)
    low = 2 * np.arange(count - 1)
    faces = np.concatenate([np.stack([low, low + 2, low + 1], 1), np.stack([low + 1, low + 2, low + 3], 1)])
    return Mesh(np.concatenate([vertices, [[9.0, 9.0, 9.0]]]), np.concatenate([faces, [[0, 0, 1]]]))

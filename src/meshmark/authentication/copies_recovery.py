"""Recovery of a scene with copies: what came back in the place of the original goes to the place of each copy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshmark.io.derived import derived
from meshmark.mesh import IntArray, Mesh
from meshmark.recovery.repair import Recovered
from meshmark.scene.distinct import Distinct
from meshmark.scene.surfaces import Unfolded

__all__ = ["folded", "scene_again"]


def folded(surface: Unfolded, made: Recovered) -> Recovered:
    """Return what was recovered of an unfolded surface with all points in their places in the scene."""
    place = _carried(np.append(surface.place, -1)[made.origin], made.faces)
    points = made.points.copy()
    for number, affine in enumerate(surface.maps):
        if number:
            points[place == number] = affine(points[place == number])
    return replace(made, points=points)


def scene_again(once: Distinct, mesh: Mesh, origin: IntArray) -> Mesh:
    """Return the scene in which each mesh is as it is in `mesh`, recovered from `once.mesh`.

    origin: (n,) the vertex of `once.mesh` that each vertex was, -1 for new ones.
    """
    if np.array_equal(mesh.faces, once.mesh.faces) and len(mesh.vertices) == len(once.rows):
        return once.whole(mesh.vertices)
    own = _carried(np.append(once.showing[once.rows], -1)[origin], mesh.faces)
    vertices, faces, origins, count = [], [], [], 0
    for (image, home), affine in once.maps.items():
        at = np.full(len(once.rows), -1)
        there = once.showing == image
        at[once.row[there]] = np.flatnonzero(there)
        scene = np.append(at, -1)[origin]
        shown = (own == home) & ((scene >= 0) | (origin < 0))
        rename = np.cumsum(shown) - 1 + count
        faces.append(rename[mesh.faces[shown[mesh.faces].all(axis=1)]])
        vertices.append(affine(mesh.vertices[shown]))
        origins.append(scene[shown])
        count += int(shown.sum())
    return derived(once.scene, np.concatenate(vertices), np.concatenate(faces), np.concatenate(origins))


def _carried(values: IntArray, faces: IntArray) -> IntArray:
    """Return values (p,) where those that are below 0 have that of a neighbour, 0 where no neighbour has one."""
    values = values.copy()
    while (values[faces] < 0).any():
        most = values[faces].max(axis=1)
        before = values.copy()
        for corner in faces.T:
            open_ = (before[corner] < 0) & (most >= 0)
            values[corner[open_]] = most[open_]
        if np.array_equal(before, values):
            break
    return np.maximum(values, 0)

"""A part of the model replaced by another piece that fits into the same boundary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_delete import without_loose
from meshmark.attacks.local_patch import Patch, draw_patch, unit
from meshmark.attacks.subdivision import sqrt3_faces
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["replace_part"]

WAVES = 4
DETAIL = 0.1
"""Height of the new detail over the radius of the part."""
WAVELENGTH = 0.6
"""Length of its waves over that radius."""


def replace_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Replace the share `strength` of the vertices, around a random one, by a new piece of surface.

    The faces there make way for finer ones (root-3 pattern, boundary unchanged), which are smoothed until only the
    boundary and the coarsest shape hold them, and get waves of their own. `altered` marks all vertices of the new
    piece but the boundary; they have no origin. All others stay bit by bit, boundary included. Raises `InputError`
    for a share of 1 or more, and a mesh without faces.
    """
    patch = draw_patch(mesh, strength, rng)
    welded = patch.welded
    old = patch.holds[welded.faces].any(axis=1)
    middles = welded.faces[old]
    fans = sqrt3_faces(middles, len(welded.points))
    points = np.concatenate([welded.points, welded.points[middles].mean(axis=1)])
    free = np.concatenate([patch.holds, np.ones(len(middles), bool)])
    reach = np.ones(len(points))
    reach[patch.members] = patch.reach
    reach[len(welded.points) :] = reach[middles].mean(axis=1)
    points[free] = _smooth(points, fans, free)
    points[free] += _detail(points[free], reach[free], patch, rng)
    return _joined(patch, points, fans, free)


def _smooth(points: FloatArray, faces: IntArray, free: NDArray[np.bool_]) -> FloatArray:
    """Return where the free points balance their neighbours, held a little to where they were.

    The hold is so weak that it is felt over the size of the patch only.
    """
    count = int(free.sum())
    graph = adjacency(unique_edges(faces), len(points))[free]
    degree = np.asarray(graph.sum(axis=1))
    hold = degree / count
    matrix = csc_array(diags_array(degree + hold) - graph[:, free])
    pull = hold[:, None] * points[free] + graph[:, ~free] @ points[~free]
    return np.asarray(splu(matrix).solve(pull))


def _detail(points: FloatArray, reach: FloatArray, patch: Patch, rng: np.random.Generator) -> FloatArray:
    height = np.zeros(len(points))
    for _ in range(WAVES):
        wave = 2.0 * np.pi / (WAVELENGTH * patch.radius) * unit(rng)
        height += np.cos((points - patch.points[0]) @ wave + rng.uniform(0.0, 2.0 * np.pi)) / WAVES
    height *= DETAIL * patch.radius * (1.0 - reach**2)
    return np.asarray(height[:, None] * patch.normal)


def _joined(patch: Patch, points: FloatArray, fans: IntArray, free: NDArray[np.bool_]) -> Attacked:
    """Put the new piece into the mesh: its free points become vertices after the old ones."""
    mesh, welded = patch.mesh, patch.welded
    inside = patch.holds[welded.point_of_vertex]
    first_new = len(mesh.vertices)
    number = np.full(len(points), -1)
    number[: len(welded.points)] = welded.vertex_of_point
    number[free] = first_new + np.arange(int(free.sum()))
    kept = mesh.faces[~inside[mesh.faces].any(axis=1)]
    lost = np.zeros(first_new + int(free.sum()), bool)
    lost[mesh.faces[inside[mesh.faces].any(axis=1)]] = True
    return without_loose(
        np.concatenate([mesh.vertices, points[free]]),
        np.concatenate([kept, number[fans]]),
        np.concatenate([np.arange(first_new), np.full(int(free.sum()), -1)]),
        np.arange(len(lost)) >= first_new,
        lost,
    )

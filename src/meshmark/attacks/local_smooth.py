"""A part of the model gone over with a smoothing brush."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.local_patch import draw_patch
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import Mesh

__all__ = ["smooth_part"]

PASSES = 5
STRONGEST = 0.5
"""At the centre a point goes so far to the mean of its neighbours in each pass."""


def smooth_part(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Smooth the share `strength` of the vertices, around a random one, in five passes.

    Each goes 0.5 (1 - s^2) of the way to the mean of its neighbours, all at once; s is the distance along the
    surface from the centre over the radius. All other vertices stay bit by bit; so does one that is the mean of
    its neighbours. Raises `InputError` for a share of 1 or more, and a mesh without faces.
    """
    patch = draw_patch(mesh, strength, rng)
    points = patch.welded.points.copy()
    graph = adjacency(unique_edges(patch.welded.faces), len(points))[patch.members]
    degree = np.maximum(np.asarray(graph.sum(axis=1)), 1.0)[:, None]
    way = STRONGEST * (1.0 - patch.reach**2)[:, None]
    for _ in range(PASSES):
        here = points[patch.members]
        points[patch.members] = here + way * ((graph @ points) / degree - here)
    return patch.moved_to(points[patch.members])

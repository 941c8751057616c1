"""Shells that are gone: parts of the miniature that hang together with nothing that is left."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.components import connected_components
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.long_edges import split_long_edges

__all__ = ["with_lost_shells"]

# A shell is gone where all of its points lie this many times as far off the surface as the miniature does usually.
FAR = 6.0
# Its faces become as small as so many edges of the surface.
LONGER = 1.5


def with_lost_shells(
    points: FloatArray, faces: IntArray, mini: tuple[FloatArray, IntArray], usual: float
) -> tuple[FloatArray, IntArray]:
    """Return the surface with the miniature's shells that it lacks, behind its own points and faces.

    mini: points and faces in the same coordinates; usual: how far it lies off the surface, in scene units.
    """
    places, corners = mini
    shell = connected_components(adjacency(unique_edges(corners), len(places)))[1]
    near = SurfaceIndex(points, faces).nearest(places).distances <= FAR * usual
    gone = np.bincount(shell, near) == 0
    gone &= np.bincount(shell) >= 4
    part = corners[gone[shell[corners[:, 0]]]]
    if not len(part):
        return points, faces
    edges = unique_edges(faces)
    size = float(np.sqrt(((points[edges[:, 0]] - points[edges[:, 1]]) ** 2).sum(axis=1).mean()))
    used, corners = np.unique(part, return_inverse=True)
    new, made = split_long_edges(places[used], corners.reshape(-1, 3), LONGER * size)
    return np.concatenate([points, new]), np.concatenate([faces, made + len(points)])

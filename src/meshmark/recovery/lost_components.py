"""Lost connected components: parts of the miniature that are connected to nothing that is left."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.components import connected_components
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.long_edges import split_long_edges

__all__ = ["with_lost_components"]

# A component is lost where all of its points lie this many times the miniature's usual distance off the surface.
FAR = 6.0
# Its faces become as small as this many edges of the surface.
LONGER = 1.5


def with_lost_components(
    points: FloatArray, faces: IntArray, mini: tuple[FloatArray, IntArray], usual: float
) -> tuple[FloatArray, IntArray]:
    """Return the surface with the miniature's connected components that it lacks, behind its own points and faces.

    mini: points and faces in the same coordinates; usual: how far it lies off the surface, in scene units.
    """
    places, corners = mini
    component = connected_components(adjacency(unique_edges(corners), len(places)))[1]
    near = SurfaceIndex(points, faces).nearest(places).distances <= FAR * usual
    gone = np.bincount(component, near) == 0
    gone &= np.bincount(component) >= 4
    part = corners[gone[component[corners[:, 0]]]]
    if not len(part):
        return points, faces
    edges = unique_edges(faces)
    size = float(np.sqrt(((points[edges[:, 0]] - points[edges[:, 1]]) ** 2).sum(axis=1).mean()))
    used, corners = np.unique(part, return_inverse=True)
    new, made = split_long_edges(places[used], corners.reshape(-1, 3), LONGER * size)
    return np.concatenate([points, new]), np.concatenate([faces, made + len(points)])

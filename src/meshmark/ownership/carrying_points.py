"""Which points of a marked surface carry the bits of the mark of the whole, so that others may carry more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.surface_of import surface_of_moved
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import Framed

__all__ = ["carrying_points"]


def carrying_points(task: EmbeddingTask, owned: Owned) -> NDArray[np.bool_]:
    """Return which points (p,) carry bits of the mark of the whole; none where it is in cells."""
    surface = surface_of_moved(owned.mesh, task.mesh)
    if not owned.mark.at_points or len(surface.points) != len(task.surface.points):
        return np.zeros(len(task.surface.points), bool)
    lattice = PointLattice.keyed(task.key, owned.mark.label)
    frame = owned.mark.frame
    framed = Framed.of(surface, Carried.of(surface, frame), frame, lattice)
    choice = framed.best_at(owned.mark.step * owned.mark.spacing)
    return np.asarray(framed.carrying(choice).any(axis=1))

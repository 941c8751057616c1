"""How the cells' offsets answer to what smoothing and noise do to the points around them.

Both act point by point. Offsets are linear in small displacements d of the points (`cell_gradient`): those of
the umbrella operator U = (mean of the neighbours) - point, which smoothing moves points along, and of U^2, which
undoing a smoothing leaves an error along; and those of independent noise as strong as the surface is rough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import area_vectors, sum_at_points
from meshmark.geometry.sampling import Samples
from meshmark.geometry.scale_space import random_walk
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import Cells, cell_gradient

__all__ = ["Relief", "measure_relief"]


@dataclass(frozen=True, eq=False)
class Relief:
    """Of n cells, all in spacings.

    bending: (n, 2) change of each offset where every point moves by U, and by U^2.
    grain:   (n,) standard deviation of each offset under noise of the points as large as their U is along their
             normals.
    """

    bending: FloatArray
    grain: FloatArray

    def take(self, index: IntArray) -> Relief:
        """Return the rows of these cells."""
        return Relief(self.bending[index], self.grain[index])


def measure_relief(points: FloatArray, faces: IntArray, cells: Cells) -> Relief:
    """Measure points (p, 3), in lattice coordinates, around `cells` that were read off them."""
    vectors = sum_at_points(area_vectors(points, faces) / 3.0, faces, len(points))
    areas = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    walk = random_walk(points, unique_edges(faces))
    first = walk @ points - points
    flux = np.stack([np.einsum("ij,ij->i", move, vectors) for move in (first, walk @ first - first)], axis=1)
    gradient = cell_gradient(Samples(positions=points, vectors=vectors, areas=areas), cells)
    bending = np.asarray(gradient @ flux)
    weight = abs(gradient)
    height = np.divide(flux[:, 0], areas, out=np.zeros(len(areas)), where=areas > 0.0)
    around = np.maximum(weight @ areas, np.finfo(float).tiny)
    rough = np.sqrt(weight @ (areas * height**2) / around)
    spread = np.sqrt(gradient.power(2) @ areas**2)
    return Relief(bending, np.asarray(spread * rough))

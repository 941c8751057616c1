"""How the cells' offsets answer to what smoothing and noise do to the points around them.

Both act point by point. Offsets are linear in small displacements d of the points (`cell_gradient`): those of
the umbrella operator U = (mean of the neighbours) - point, which smoothing moves points along, and of U^2, which
undoing a smoothing leaves an error along; and those of independent noise as strong as the surface is rough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.areas import area_vectors, sum_at_points
from meshmark.geometry.connectivity import Connectivity
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import Cells, gradient_pairs

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


def measure_relief(points: FloatArray, joined: Connectivity, cells: Cells) -> Relief:
    """Measure points (p, 3), in lattice coordinates, around `cells` that were read off them."""
    vectors = sum_at_points(area_vectors(points, joined.faces) / 3.0, joined.faces, len(points))
    areas = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    first = joined.walk @ points - points
    flux, again = (np.einsum("ij,ij->i", move, vectors) for move in (first, joined.walk @ first - first))
    height = np.divide(flux, areas, out=np.zeros(len(areas)), where=areas > 0.0)
    sums = np.zeros((5, len(cells.nodes)))
    weighed = areas * height**2
    for row, point, gradient in gradient_pairs(points, cells):
        size = np.abs(gradient)
        for total, terms in zip(
            sums,
            (
                gradient * flux.take(point),
                gradient * again.take(point),
                size * areas.take(point),
                size * weighed.take(point),
                (size * areas.take(point)) ** 2,
            ),
            strict=True,
        ):
            total += np.bincount(row, terms, len(total))
    rough = np.sqrt(sums[3] / np.maximum(sums[2], np.finfo(float).tiny))
    return Relief(sums[:2].T.copy(), np.sqrt(sums[4]) * rough)

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

__all__ = ["Relief", "Umbrellas", "measure_relief"]


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


@dataclass(frozen=True, eq=False, kw_only=True)
class Umbrellas:
    """What U and U^2 do to the flux through each of p points, in the unit of the positions.

    flux: (2, p) of the moves by U and U^2 through the points' area vectors. areas: (p,) the length of these.
    """

    flux: FloatArray
    areas: FloatArray

    @classmethod
    def of(cls, points: FloatArray, joined: Connectivity) -> Umbrellas:
        """Measure points (p, 3)."""
        vectors = sum_at_points(area_vectors(points, joined.faces) / 3.0, joined.faces, len(points))
        first = joined.walk @ points - points
        moves = first, joined.walk @ first - first
        return cls(
            flux=np.stack([np.einsum("ij,ij->i", move, vectors) for move in moves]),
            areas=np.sqrt(np.einsum("ij,ij->i", vectors, vectors)),
        )

    def scaled(self, size: float) -> Umbrellas:
        """Return those of points that were moved, turned and scaled by `size`."""
        return Umbrellas(flux=self.flux * size**3, areas=self.areas * size**2)


def measure_relief(points: FloatArray, moves: Umbrellas, cells: Cells) -> Relief:
    """Measure points (p, 3), in lattice coordinates, and their moves around `cells` that were read off them."""
    areas = moves.areas
    height = np.divide(moves.flux[0], areas, out=np.zeros(len(areas)), where=areas > 0.0)
    weighed = areas * height**2
    sums = np.zeros((5, len(cells.nodes)))
    for row, point, gradient in gradient_pairs(points, cells):
        first, again = (gradient * flux.take(point) for flux in moves.flux)
        size = np.abs(gradient)
        reached = size * areas.take(point)
        terms = first, again, reached, size * weighed.take(point), reached**2
        for total, values in zip(sums, terms, strict=True):
            total += np.bincount(row, values, len(total))
    rough = np.sqrt(sums[3] / np.maximum(sums[2], np.finfo(float).tiny))
    return Relief(sums[:2].T.copy(), np.sqrt(sums[4]) * rough)

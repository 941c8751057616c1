"""The barycentre statistic of every lattice cell (DESIGN section 4; paper eq. 9-10).

For the cell at node c with window w, samples x_f and area vectors a_f, in lattice coordinates (spacing 1):

    s = sum_f w(x_f) (x_f - c) . a_f / | sum_f w(x_f) a_f |

is the offset of the patch's barycentre from the node along the patch's normal. Numerator and denominator are
fluxes, linear in the area vectors: vertex noise averages out and remeshing hardly changes them.

The window is w = (1 - r^2)^3 for r < 1: as smooth as the Gaussian of sigma 0.38 spacings it resembles, but a
sample reaches only the eight nodes around it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.blocks import blocks
from meshmark.geometry.open_edges import EdgeSamples
from meshmark.geometry.sampling import Samples
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Cells", "border_gradient", "cell_gradient", "measure_cells"]

PLANE_MASS = np.pi / 4.0  # integral of the window over a plane through its node
POWER = 3
_CORNERS = tuple((i, j, k) for i, j, k in product((0, 1), repeat=3))


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells that a surface touches, n of them.

    nodes:    (n, 3) integer lattice coordinates.
    offset:   (n,) the statistic s, in spacings.
    normal:   (n, 3) unit patch normal, in lattice axes.
    mass:     (n,) flux through the window over that of a plane through the node; 1 is a full flat patch.
    flatness: (n,) flux over windowed area, in [0, 1]; 1 where all normals agree.
    """

    nodes: IntArray
    offset: FloatArray
    normal: FloatArray
    mass: FloatArray
    flatness: FloatArray

    def take(self, index: IntArray) -> Cells:
        """Return the cells with these positions."""
        return Cells(
            self.nodes[index], self.offset[index], self.normal[index], self.mass[index], self.flatness[index]
        )


@dataclass(frozen=True, eq=False)
class _Grid:
    """Linear numbers of the nodes in a box: low corner (3,) and sizes (3,)."""

    low: IntArray
    sizes: IntArray

    @classmethod
    def around(cls, base: IntArray) -> _Grid:
        low = base.min(axis=0)
        return cls(low, base.max(axis=0) - low + 2)

    @property
    def count(self) -> int:
        return int(np.prod(self.sizes))

    def number(self, nodes: IntArray) -> IntArray:
        i, j, k = (nodes - self.low).T
        return np.asarray((i * self.sizes[1] + j) * self.sizes[2] + k)

    def nodes(self, numbers: IntArray) -> IntArray:
        rest, k = np.divmod(numbers, self.sizes[2])
        i, j = np.divmod(rest, self.sizes[1])
        return np.column_stack([i, j, k]) + self.low


def _around(positions: FloatArray) -> tuple[_Grid, IntArray, FloatArray]:
    base = np.floor(positions).astype(np.int64)
    grid = _Grid.around(base)
    return grid, grid.number(base), positions - base


def _windows(fraction: FloatArray) -> Iterator[tuple[tuple[int, int, int], FloatArray]]:
    """Yield for each of the 8 nodes around a sample its corner and max(0, 1 - r^2) (q,)."""
    near = fraction * fraction
    far = near - 2.0 * fraction + 1.0
    squares = (near.T.copy(), far.T.copy())
    for corner in _CORNERS:
        x, y, z = (squares[bit][axis] for axis, bit in enumerate(corner))
        yield corner, np.maximum(1.0 - x - y - z, 0.0)


def _touched(grid: _Grid, number: IntArray) -> tuple[IntArray, IntArray]:
    """Return the numbers of the nodes around the samples, and for every node of the grid its place among them."""
    mark = np.zeros(grid.count, dtype=bool)
    for corner in _CORNERS:
        mark[number + grid.number(grid.low + np.array(corner))] = True
    touched = np.flatnonzero(mark)
    place = np.zeros(grid.count, np.int64)
    place[touched] = np.arange(len(touched))
    return touched, place


def measure_cells(samples: Samples) -> Cells:
    """Measure every cell touched by samples given in lattice coordinates, (q, 3)."""
    grid, number, fraction = _around(samples.positions)
    touched, place = _touched(grid, number)
    sums = np.zeros((5, len(touched)))
    for part in blocks(len(number)):
        ax, ay, az = vectors = np.ascontiguousarray(samples.vectors[part].T)
        flux = np.einsum("qi,iq->q", fraction[part], vectors)
        for corner, inside in _windows(fraction[part]):
            window = inside * inside * inside
            target = place.take(number[part] + grid.number(grid.low + np.array(corner)))
            through = flux.copy()
            for axis, bit in enumerate(corner):
                if bit:
                    through -= vectors[axis]
            for row, values in enumerate((ax, ay, az, through, samples.areas[part])):
                sums[row] += np.bincount(target, window * values, len(touched))
    seen = sums[4] > 0.0
    touched, sums = touched[seen], sums[:, seen]
    strength = np.sqrt(sums[0] ** 2 + sums[1] ** 2 + sums[2] ** 2)
    safe = np.where(strength > 0.0, strength, 1.0)
    return Cells(
        grid.nodes(touched), sums[3] / safe, (sums[:3] / safe).T, strength / PLANE_MASS, strength / sums[4]
    )


def cell_gradient(samples: Samples, cells: Cells) -> sp.csr_array:
    """Return (n, q): change of each cell's offset per unit of flux (displacement . area vector) at each sample.

    The flux of a field F through a moving closed surface changes by the integral of div F times the normal
    motion: div(w (x - c)) = 3 w + (x - c) . grad w for the numerator, N . grad w for the denominator's length.
    """

    def change(row: IntArray, _: IntArray, arm: FloatArray, inside: FloatArray) -> FloatArray:
        slope = -2.0 * POWER * inside ** (POWER - 1)  # grad w = slope * arm
        along = np.einsum("qi,qi->q", arm, cells.normal[row])
        return np.asarray(3.0 * inside**POWER + slope * (1.0 - inside) - cells.offset[row] * slope * along)

    return _at_pairs(samples.positions, cells, change)


def border_gradient(edges: EdgeSamples, direction: FloatArray, cells: Cells) -> sp.csr_array:
    """Return (n, e): what open edges add, per unit of displacement of each edge sample along `direction` (3,).

    The line integral of F x v, with F = w (x - c) for the numerator and w N for the denominator's length.
    """
    turned = np.cross(direction, edges.steps)

    def change(row: IntArray, sample: IntArray, arm: FloatArray, inside: FloatArray) -> FloatArray:
        field = arm - cells.offset[row, None] * cells.normal[row]
        return np.asarray(inside**POWER * np.einsum("qi,qi->q", field, turned[sample]))

    return _at_pairs(edges.positions, cells, change)


def _at_pairs(
    positions: FloatArray,
    cells: Cells,
    change: Callable[[IntArray, IntArray, FloatArray, FloatArray], FloatArray],
) -> sp.csr_array:
    """Return (n, q): `change(row, sample, arm, 1 - r^2)` over the cell's flux, for samples within its window."""
    rows, columns, values = [], [], []
    if len(positions):
        grid, number, fraction = _around(positions)
        row_of = np.full(grid.count, -1, np.int64)
        within = ((cells.nodes >= grid.low) & (cells.nodes < grid.low + grid.sizes)).all(axis=1)
        row_of[grid.number(cells.nodes[within])] = np.flatnonzero(within)
        for corner, inside in _windows(fraction):
            row = row_of[number + grid.number(grid.low + np.array(corner))]
            hit = np.flatnonzero((row >= 0) & (inside > 0.0))
            arm = fraction[hit] - np.array(corner, dtype=float)
            rows.append(row[hit])
            columns.append(hit)
            values.append(change(row[hit], hit, arm, inside[hit]) / (cells.mass[row[hit]] * PLANE_MASS))
    shape = (len(cells.nodes), len(positions))
    if not rows:
        return sp.csr_array(shape)
    return sp.csr_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape
    )

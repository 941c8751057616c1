"""The barycentre statistic of every lattice cell (docs/design.md, section 4; paper eq. 9-10).

For the cell at node c with window w, samples x_f and area vectors a_f, in lattice coordinates (spacing 1):

    s = sum_f w(x_f) (x_f - c) . a_f / | sum_f w(x_f) a_f |

is the offset of the patch's barycentre from the node along the patch's normal. Numerator and denominator are
fluxes, linear in the area vectors: vertex noise averages out and remeshing hardly changes them.

The window is w = (1 - r^2)^3 for r < 1: as smooth as the Gaussian of sigma 0.38 spacings it resembles, but a
sample reaches only the eight nodes around it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.blocks import blocks
from meshmark.geometry.open_edges import EdgeSamples
from meshmark.geometry.sampling import Samples
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.nodes import CORNERS, REACH, Surroundings, find_nodes, surroundings

__all__ = ["Cells", "border_gradient", "cell_gradient", "gradient_pairs", "measure_cells"]

_Change = Callable[[IntArray, IntArray, FloatArray, FloatArray], FloatArray]

PLANE_MASS = np.pi / 4.0  # integral of the window over a plane through its node
POWER = 3
# Samples that are added up at once.
ROWS = 1 << 14


@dataclass(frozen=True, eq=False, kw_only=True)
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
            nodes=self.nodes[index],
            offset=self.offset[index],
            normal=self.normal[index],
            mass=self.mass[index],
            flatness=self.flatness[index],
        )


def measure_cells(samples: Samples) -> Cells:
    """Measure every cell touched by samples given in lattice coordinates, (q, 3)."""
    positions = samples.positions
    if np.abs(positions).max(initial=0.0) >= REACH - 2:
        near = np.flatnonzero((np.abs(positions) < REACH - 2).all(axis=1))
        samples = Samples(positions=positions[near], vectors=samples.vectors[near], areas=samples.areas[near])
    around = surroundings(samples.positions)
    sums = _sums(samples, around)
    seen = sums[4] > 0.0
    sums = sums[:, seen]
    strength = np.sqrt(sums[0] ** 2 + sums[1] ** 2 + sums[2] ** 2)
    safe = np.where(strength > 0.0, strength, 1.0)
    offset, normal = sums[3] / safe, (sums[:3] / safe).T
    return Cells(
        nodes=around.nodes[seen],
        offset=offset,
        normal=normal,
        mass=strength / PLANE_MASS,
        flatness=strength / sums[4],
    )


def _sums(samples: Samples, around: Surroundings) -> FloatArray:
    """Return (5, n): windowed sums of area vectors, of flux from the node, and of areas, at every node.

    Summed by lattice cubes first, for each corner: one sparse product for all five.
    """
    cubes = len(around.place)
    sums = np.zeros((len(CORNERS), cubes, 5))
    vectors = np.ascontiguousarray(samples.vectors.T)
    for part in blocks(len(samples.areas), ROWS):
        ax, ay, az = vectors[:, part]
        x, y, z = around.fraction[:, part]
        flux = x * ax + y * ay + z * az
        values = np.stack([ax, ay, az, flux, samples.areas[part]], axis=1)
        count = len(values)
        into = sp.csc_array(
            (np.ones(count), around.cube[part], np.arange(count + 1, dtype=np.int32)), shape=(cubes, count)
        )
        for total, inside in zip(sums, around.windows(part), strict=True):
            into.data = inside * inside * inside
            total += into @ values
    for total, corner in zip(sums, CORNERS, strict=True):
        for axis in np.flatnonzero(corner):
            total[:, 3] -= total[:, axis]
    row = around.place.T.ravel()
    by_corner = sums.reshape(-1, 5).T
    return np.stack([np.bincount(row, each, len(around.nodes)) for each in by_corner])


def cell_gradient(samples: Samples, cells: Cells) -> sp.csr_array:
    """Return (n, q): change of each cell's offset per unit of flux (displacement . area vector) at each sample.

    The flux of a field F through a moving closed surface changes by the integral of div F times the normal
    motion: div(w (x - c)) = 3 w + (x - c) . grad w for the numerator, N . grad w for the denominator's length.
    """
    return _matrix(samples.positions, cells, _flux_change(cells))


def gradient_pairs(positions: FloatArray, cells: Cells) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Yield cells, samples and `cell_gradient` (k,) of each for samples at positions (q, 3), some at a time."""
    return _pairs(positions, cells, _flux_change(cells), blocks(len(positions)))


def _flux_change(cells: Cells) -> _Change:
    def change(row: IntArray, _: IntArray, arm: FloatArray, inside: FloatArray) -> FloatArray:
        slope = -2.0 * POWER * inside ** (POWER - 1)  # grad w = slope * arm
        along = np.einsum("qi,qi->q", arm, cells.normal.take(row, axis=0))
        return np.asarray(3.0 * inside**POWER + slope * (1.0 - inside) - cells.offset[row] * slope * along)

    return change


def border_gradient(edges: EdgeSamples, direction: FloatArray, cells: Cells) -> sp.csr_array:
    """Return (n, e): what open edges add, per unit of displacement of each edge sample along `direction` (3,).

    The line integral of F x v, with F = w (x - c) for the numerator and w N for the denominator's length.
    """
    turned = np.cross(direction, edges.steps)

    def change(row: IntArray, sample: IntArray, arm: FloatArray, inside: FloatArray) -> FloatArray:
        field = arm - cells.offset[row, None] * cells.normal[row]
        return np.asarray(inside**POWER * np.einsum("qi,qi->q", field, turned[sample]))

    return _matrix(edges.positions, cells, change)


def _matrix(positions: FloatArray, cells: Cells, change: _Change) -> sp.csr_array:
    """Return (n, q): `change(row, sample, arm, 1 - r^2)` over the cell's flux, for samples within its window."""
    shape = (len(cells.nodes), len(positions))
    if 0 in shape:
        return sp.csr_array(shape)
    pairs = [
        (row.astype(np.int32), column.astype(np.int32), value)
        for row, column, value in _pairs(positions, cells, change, blocks(len(positions)))
    ]
    rows, columns, values = map(np.concatenate, zip(*pairs, strict=True))
    del pairs
    return sp.csr_array((values, (rows, columns)), shape=shape)


def _pairs(
    positions: FloatArray, cells: Cells, change: _Change, parts: Iterable[slice]
) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Yield rows of cells, samples and values of the matrix, for each part of the samples and corner of cubes."""
    around = surroundings(np.clip(positions, 2 - REACH, REACH - 2))
    row_of = find_nodes(cells.nodes, around.nodes)
    for part in parts:
        start, fraction, cube = part.start or 0, around.fraction[:, part], around.cube[part]
        for corner, place, inside in zip(CORNERS, around.place.T, around.windows(part), strict=True):
            row = row_of.take(place).take(cube)
            hit = np.flatnonzero((row >= 0) & (inside > 0.0))
            row = row[hit]
            arm = np.ascontiguousarray(fraction.take(hit, axis=1).T) - corner
            moved = change(row, start + hit, arm, inside[hit])
            yield row, start + hit, moved / (cells.mass[row] * PLANE_MASS)

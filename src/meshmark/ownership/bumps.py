"""Smooth displacement fields that move many cells' offsets, and the frame, by chosen amounts.

Displacements go along vertex normals, d = P R^-1 P' J' x with J the gradient of offsets and frame moments, P
smooth functions on the surface and R = P' Q P, Q the visible energy: of all sums of those functions that change
offsets and moments alike, the least visible (docs/decisions/0019).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshmark.errors import CapacityError
from meshmark.geometry.areas import add_at_points, area_vectors, face_areas, vertex_areas_and_normals
from meshmark.geometry.blocks import blocks
from meshmark.geometry.frame import surface_moments
from meshmark.geometry.open_edges import sample_open_edges
from meshmark.geometry.sampling import Sampler, Samples
from meshmark.geometry.surface_basis import surface_basis
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import Cells, border_gradient, cell_gradient
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.parameters import LONGEST_SAMPLE
from meshmark.ownership.visible_energy import visible_energy

__all__ = ["FRAME_ROWS", "Bumps", "frame_gradient", "frame_values", "symmetric"]

FRAME_ROWS = 9
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
# A cell whose offset is tied to the others' to this degree cannot be set on its own.
LEAST_FREEDOM = 0.05
# A cell that costs this many times what most do (a window on an edge, or on few vertices) would take most of the
# budget and show as a dent: it is left as it is, one wrong bit at worst half the time, which the code repairs.
DEAREST = 6.0
RIDGE = 1e-9
# Lift of the energy's diagonal, over its median: functions may coincide where the mesh is coarse.
LIFT = 1e-6
# Distance of the nodes of the smooth functions, in spacings.
PITCH = 0.5
# A function whose points nearly all stay where they are is left out: the sum of its values is below this.
LEAST_WEIGHT = 0.1
# Points whose part of the energy is added at once.
ROWS = 1 << 16


def frame_values(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (9,): centroid and second moments (xx, yy, zz, xy, xz, yz) per unit area."""
    _, centre, second = surface_moments(points, faces)
    return np.concatenate([centre, [second[i, j] for i, j in _PAIRS]])


def symmetric(values: FloatArray) -> FloatArray:
    """Return the (3, 3) matrix of second moments (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz, xy, xz, yz = values
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def frame_gradient(points: FloatArray, faces: IntArray, normals: FloatArray) -> FloatArray:
    """Return (9, p): change of `frame_values` per unit of motion along each point's normal.

    Exact for flat triangles and `points` centred: of each face's integrals, area times mean of x or of x y, both
    factors change. The mean of x y over a triangle is (sum of x y over corners + 9 x y of the middle) / 12.
    """
    areas = face_areas(points, faces)
    total = areas.sum()
    whole = [float(areas @ _product_means(points, faces, pair)) / total for pair in _PAIRS]
    sums, own = np.zeros((len(points), FRAME_ROWS)), np.empty((len(points), FRAME_ROWS))
    for corner in range(3):
        own[:] = 0.0
        for part in blocks(len(faces)):
            changes = _frame_changes((points, normals), faces[part], areas[part], whole, corner)
            add_at_points(own, changes, faces[part, corner : corner + 1])
        sums += own
    sums /= total
    return sums.T


def _product_means(points: FloatArray, faces: IntArray, pair: tuple[int, int]) -> FloatArray:
    """Return (m,): the mean over each face of the product of two coordinates."""
    out = np.empty(len(faces))
    for part in blocks(len(faces)):
        corners = _by_axis(points, faces[part])
        one, other = (corners[axis] for axis in pair)
        out[part] = ((one * other).sum(axis=0) + 9.0 * one.mean(axis=0) * other.mean(axis=0)) / 12.0
    return out


def _by_axis(values: FloatArray, faces: IntArray) -> FloatArray:
    """Return (3, 3, m): for each axis and corner the values (p, 3) at the faces."""
    return np.ascontiguousarray(np.moveaxis(values.take(faces.T, axis=0), 2, 0))


def _frame_changes(
    moving: tuple[FloatArray, FloatArray], faces: IntArray, areas: FloatArray, whole: list[float], corner: int
) -> FloatArray:
    """Return (m, 9): change of the integrals of each face as one of its corners moves along its normal.

    moving: points and their normals; whole: the means of the products over all faces.
    """
    ends, turns = (list(_by_axis(values, faces)) for values in moving)
    vectors = area_vectors(moving[0], faces)
    units = (vectors / np.where(areas > 0.0, areas, 1.0)[:, None]).T
    middles = [end.mean(axis=0) for end in ends]
    growth = _area_growth(ends, [turn[corner] for turn in turns], units, corner)
    motion = [areas * turn[corner] for turn in turns]
    changes = [growth * middles[i] + motion[i] / 3.0 for i in range(3)]
    for mean, (i, j) in zip(whole, _PAIRS, strict=True):
        value = ((ends[i] * ends[j]).sum(axis=0) + 9.0 * middles[i] * middles[j]) / 12.0 - mean
        lever = motion[i] * (ends[j][corner] + 3.0 * middles[j])
        lever += motion[j] * (ends[i][corner] + 3.0 * middles[i])
        changes.append(growth * value + lever / 12.0)
    return np.stack(changes, axis=1)


def _area_growth(
    ends: list[FloatArray], turn: list[FloatArray], units: FloatArray, corner: int
) -> FloatArray:
    """Return (m,): growth of each face's area as one corner moves along `turn`."""
    across = [end[(corner + 1) % 3] - end[(corner + 2) % 3] for end in ends]
    parts = [
        turn[i] * (across[j] * units[k] - across[k] * units[j])
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    ]
    return np.asarray(0.5 * (parts[0] + parts[1] + parts[2]))


class Bumps:
    """The smooth displacements for n cells of one surface.

    Lengths are in lattice coordinates, changes of frame values in canonical units, of offsets in spacings.
    normals: (p, 3) in lattice axes. basis: (p, m) the smooth functions.
    free:   (n,) True for cells that can be set; the others are tied to their neighbours and left alone.
    spread: (f,) change of free offsets, in spacings, where each point moves at random by one lattice unit (RMS).
    cost:   (f, f) energy of offset changes of the f free cells, the frame held.
    """

    def __init__(
        self,
        sampler: Sampler,
        samples: Samples,
        cells: Cells,
        lattice: Lattice,
        seen: VisibleChange,
        *,
        still: NDArray[np.bool_] | None = None,
    ) -> None:
        """still: (p,) points that stay where they are; none where it is left out."""
        from scipy.linalg import cho_factor, cho_solve, pinvh

        # What takes much room is made after what takes more on the way.
        faces, placed = sampler.faces, samples.positions[: sampler.count]
        areas, self.normals = vertex_areas_and_normals(placed, faces)
        frame = frame_gradient(lattice.points(placed), faces, self.normals @ lattice.axes)
        visible = visible_energy(placed, faces, areas, frame, seen)
        offsets = cell_gradient(samples, cells) @ sampler.normal_motion(samples, self.normals)
        offsets = sp.csr_array(offsets + _border_part(placed, faces, self.normals, cells))
        spread = np.sqrt(np.asarray(offsets.multiply(offsets).sum(axis=1)).ravel())
        self.basis = surface_basis(placed, self.normals, PITCH)
        if still is not None:
            moving = sp.csr_array(sp.diags_array((~still).astype(np.float64)) @ self.basis)
            self.basis = moving[:, np.asarray(moving.sum(axis=0)).ravel() > LEAST_WEIGHT]
            if not self.basis.shape[1]:
                raise CapacityError("all of the surface is plane")
        energy = _energy(self.basis, visible)
        del visible
        energy[np.diag_indices_from(energy)] += LIFT * float(np.median(energy.diagonal()))
        onto = np.hstack([self.basis.T @ (lattice.spacing * frame.T), (self.basis.T @ offsets.T).toarray()])
        del frame, offsets
        factor = cho_factor(energy, overwrite_a=True, check_finite=False)
        self._heights = cho_solve(factor, onto, check_finite=False)
        gram = onto.T @ self._heights
        gram = 0.5 * (gram + gram.T)
        rows = _independent(gram, FRAME_ROWS)
        inverse = _inverse(gram, rows)
        if len(rows) > FRAME_ROWS:
            cost = np.diag(inverse)
            rows = rows[(rows < FRAME_ROWS) | (cost <= DEAREST * np.median(cost[FRAME_ROWS:]))]
            inverse = _inverse(gram, rows)
        self.free = np.zeros(len(cells.nodes), dtype=bool)
        self.free[rows[FRAME_ROWS:] - FRAME_ROWS] = True
        self.spread = spread[self.free]
        self._heights = self._heights[:, np.concatenate([np.full(FRAME_ROWS, True), self.free])]
        self._inverse = inverse
        self._frame_inverse = pinvh(gram[:FRAME_ROWS, :FRAME_ROWS], rtol=RIDGE)
        self.cost = inverse[FRAME_ROWS:, FRAME_ROWS:]
        self._followed = gram[FRAME_ROWS:, :FRAME_ROWS][self.free] @ self._frame_inverse

    def displacement(self, frame: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return (p,) lengths along the normals that change the frame values (9,) and free offsets (f,) so."""
        return np.asarray(self.basis @ self.coefficients(frame, offsets))

    def coefficients(self, frame: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return the same displacement as coefficients (m,) of the functions of `basis`."""
        return np.asarray(self._heights @ (self._inverse @ np.concatenate([frame, offsets])))

    def bend(self, frame: FloatArray) -> FloatArray:
        """Return (p,) lengths that change the frame values (9,) so; offsets may follow.

        A gentle bend of the whole, where holding every offset as well would push at the few places without cells.
        """
        return np.asarray(self.basis @ (self._heights[:, :FRAME_ROWS] @ (self._frame_inverse @ frame)))

    def followed(self, frame: FloatArray) -> FloatArray:
        """Return (f,): how the free offsets follow such a bend."""
        return np.asarray(self._followed @ frame)


def _energy(basis: sp.csr_array, energy: sp.csr_array) -> FloatArray:
    """Return (m, m): an energy (p, p) of lengths, of coefficients of the functions of a basis (p, m).

    A block of points at a time: the product of both takes ten times what the basis does.
    """
    total = np.zeros((basis.shape[1], basis.shape[1]))
    for block in blocks(energy.shape[0], ROWS):
        total += (basis[block].T @ (energy[block] @ basis)).toarray()
    return total


def _border_part(points: FloatArray, faces: IntArray, normals: FloatArray, cells: Cells) -> sp.csr_array:
    """Return (n, p): the part of the offsets' gradient that open edges add."""
    edges = sample_open_edges(points, faces, LONGEST_SAMPLE)
    parts = [
        border_gradient(edges, np.eye(3)[axis], cells) @ edges.motion.multiply(normals[None, :, axis])
        for axis in range(3)
    ]
    return sp.csr_array(parts[0] + parts[1] + parts[2])


def _inverse(gram: FloatArray, rows: IntArray) -> FloatArray:
    """Return the inverse of the chosen rows and columns of a Gram matrix."""
    from scipy.linalg import cho_factor, cho_solve

    part = gram[np.ix_(rows, rows)]
    # Scaled to a unit diagonal, and lifted by a trace of it: frame rows of symmetric surfaces may coincide.
    scale = 1.0 / np.sqrt(np.maximum(np.diag(part), np.finfo(float).tiny))
    factor = cho_factor(part * np.outer(scale, scale) + RIDGE * np.eye(len(rows)))
    return np.asarray(cho_solve(factor, np.eye(len(rows))) * np.outer(scale, scale))


def _independent(gram: FloatArray, first: int) -> IntArray:
    """Return in rising order the rows that a pivoted Cholesky factorisation takes while each adds freedom.

    The first `first` rows are taken in any case, before the others.
    """
    rest = np.diag(gram).copy()
    floor = LEAST_FREEDOM * rest
    floor[:first] = RIDGE * rest[:first]
    factor = np.zeros_like(gram)
    chosen: list[int] = list(range(first))
    available = rest > 0.0
    for step in range(len(gram)):
        excess = np.where(available, rest / np.where(floor > 0.0, floor, 1.0), 0.0)
        pivot = step if step < first else int(np.argmax(excess))
        available[pivot] = False
        if excess[pivot] <= 1.0:
            if step < first:
                continue
            break
        if step >= first:
            chosen.append(pivot)
        column = (gram[:, pivot] - factor[:, :step] @ factor[pivot, :step]) / np.sqrt(rest[pivot])
        factor[:, step] = column
        rest = np.maximum(rest - column * column, 0.0)
    return np.sort(chosen)

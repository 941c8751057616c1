"""Smooth displacement fields that move many cells' offsets, and the frame, by chosen amounts.

Displacements go along vertex normals, d = W^-1 J' x with J the gradient of offsets and frame moments and W the
vertex areas: of all fields with that effect the one of least energy, a sum of smooth bumps under the windows.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from meshmark.carriers.cells import Cells, cell_gradient
from meshmark.carriers.lattice import Lattice
from meshmark.geometry.areas import area_vectors, vertex_areas, vertex_normals
from meshmark.geometry.frame import surface_moments
from meshmark.geometry.sampling import Sampler, Samples
from meshmark.mesh import FloatArray, IntArray

__all__ = ["FRAME_ROWS", "Bumps", "frame_gradient", "frame_values"]

FRAME_ROWS = 9
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
# Vertices of tiny area would jump far for little effect; all count at least this share of the mean.
LEAST_AREA = 0.1
# A cell whose offset is tied to the others' to this degree cannot be set on its own.
LEAST_FREEDOM = 0.05


def frame_values(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (9,): centroid and second moments (xx, yy, zz, xy, xz, yz) per unit area."""
    _, centre, second = surface_moments(points, faces)
    return np.concatenate([centre, [second[i, j] for i, j in _PAIRS]])


def frame_gradient(points: FloatArray, faces: IntArray, normals: FloatArray) -> FloatArray:
    """Return (9, p): change of `frame_values` per unit of motion along each point's normal.

    To first order in the edge length: the integral of f changes by f times the growth of the area around the
    point plus its area times the slope of f. Needs `points` centred.
    """
    areas = vertex_areas(points, faces)
    total = areas.sum()
    growth = _area_growth(points, faces, normals)
    rows = [growth * points[:, i] + areas * normals[:, i] for i in range(3)]
    for i, j in _PAIRS:
        value = points[:, i] * points[:, j]
        slope = points[:, i] * normals[:, j] + points[:, j] * normals[:, i]
        rows.append(growth * (value - (areas @ value) / total) + areas * slope)
    return np.array(rows) / total


def _area_growth(points: FloatArray, faces: IntArray, normals: FloatArray) -> FloatArray:
    vectors = area_vectors(points, faces)
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    units = vectors / np.where(length > 0.0, length, 1.0)[:, None]
    growth = np.zeros(len(points))
    for i in range(3):
        point = faces[:, i]
        across = points[faces[:, (i + 1) % 3]] - points[faces[:, (i + 2) % 3]]
        change = 0.5 * np.einsum("ij,ij->i", normals[point], np.cross(across, units))
        growth += np.bincount(point, change, len(points))
    return growth


class Bumps:
    """The least-energy displacements for n cells of one surface.

    Lengths are in lattice coordinates, changes of frame values in canonical units, of offsets in spacings.
    normals: (p, 3) in lattice axes.
    free:   (n,) True for cells that can be set; the others are tied to their neighbours and left alone.
    cost:   (f, f) energy of offset changes of the f free cells, the frame held.
    """

    def __init__(
        self, sampler: Sampler, samples: Samples, cells: Cells, placed: FloatArray, lattice: Lattice
    ) -> None:
        faces = sampler.faces
        self.normals = vertex_normals(placed, faces)
        areas = vertex_areas(placed, faces)
        weights = np.maximum(areas, LEAST_AREA * areas.mean()) / areas.mean()
        offsets = cell_gradient(samples, cells) @ sampler.normal_motion(samples, self.normals)
        frame = frame_gradient(lattice.points(placed), faces, self.normals @ lattice.axes) * lattice.spacing
        gradient = sp.csr_array(sp.vstack([sp.csr_array(frame), offsets]))
        scaled = sp.csr_array(gradient.multiply(1.0 / weights[None, :]))
        gram = (scaled @ gradient.T).toarray()
        chosen = _independent(gram, FRAME_ROWS)
        self.free = np.zeros(len(cells.nodes), dtype=bool)
        self.free[chosen[chosen >= FRAME_ROWS] - FRAME_ROWS] = True
        rows = np.concatenate([np.arange(FRAME_ROWS), FRAME_ROWS + np.flatnonzero(self.free)])
        self._fields = sp.csr_array(scaled[rows].T)
        # The frame rows of a perfectly symmetric surface can depend on each other: a pseudo-inverse.
        self._inverse = la.pinvh(gram[np.ix_(rows, rows)], rtol=1e-10)
        self.cost = self._inverse[FRAME_ROWS:, FRAME_ROWS:]

    def displacement(self, frame: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return (p,) lengths along the normals that change the frame values (9,) and free offsets (f,) so."""
        return np.asarray(self._fields @ (self._inverse @ np.concatenate([frame, offsets])))


def _independent(gram: FloatArray, first: int) -> IntArray:
    """Return rows in the order of a pivoted Cholesky factorisation, while each adds freedom of its own.

    The first `first` rows are taken before all others.
    """
    rest = np.diag(gram).copy()
    floor = LEAST_FREEDOM * rest
    factor = np.zeros_like(gram)
    chosen: list[int] = []
    available = rest > 0.0
    for step in range(len(gram)):
        ratio = np.where(available, rest / np.where(floor > 0.0, floor, 1.0), 0.0)
        if step < first:
            pivot = step
        else:
            pivot = int(np.argmax(ratio))
            if ratio[pivot] <= 1.0:
                break
        available[pivot] = False
        if rest[pivot] <= 0.0:
            continue
        chosen.append(pivot)
        column = (gram[:, pivot] - factor[:, :step] @ factor[pivot, :step]) / np.sqrt(rest[pivot])
        factor[:, step] = column
        rest = np.maximum(rest - column * column, 0.0)
    return np.array(chosen)

"""Eigenpairs of the cotangent Laplacian, and of the graph's, by shift and invert."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from meshmark.geometry.areas import area_vectors, vertex_areas
from meshmark.mesh import FloatArray, IntArray

__all__ = ["smallest_eigenpairs", "surface_eigenpairs"]

# Of the sum of all areas: eigenvalues of a surface of area 1 are about 4 pi times their number.
SHIFT = -0.01
ZERO = 1e-4
MOST_PARTS = 40
TOLERANCE = 1e-8
# A flatter corner counts as this flat, in cotangents; a point has at least this share of the mean area.
LARGEST_COTANGENT, LEAST_AREA = 100.0, 1e-4


def surface_eigenpairs(points: FloatArray, faces: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues (k,) and functions (p, k) of L f = lambda M f on the surface scaled to area 1.

    L is the cotangent Laplacian, M the lumped mass; k is at most `count`: the constants are left out, one for each
    connected part. The functions have norm 1 in M. None are found in a model of very many parts.
    """
    areas = vertex_areas(points, faces)
    area = float(areas.sum())
    mass = np.maximum(areas / area, LEAST_AREA / len(points)) if area > 0.0 else np.full(len(points), 1.0)
    stiffness = _cotangents(points, faces)
    constants = min(connected_components(stiffness, directed=False)[0], MOST_PARTS)
    values, functions = smallest_eigenpairs(stiffness, mass, min(count + constants, len(points) - 2))
    proper = values > ZERO
    return values[proper][:count], functions[:, proper][:, :count]


def smallest_eigenpairs(stiffness: csc_array, mass: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the `count` smallest eigenvalues, rising, and vectors (p, count) of a semi-definite problem.

    The mass (p,) is diagonal. The start is fixed, so that the same matrix gives the same vectors.
    """
    weight = diags_array(mass).tocsc()
    factors = splu(
        csc_array(stiffness - SHIFT * weight),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    inverse = LinearOperator(stiffness.shape, matvec=partial(factors.solve), dtype=np.float64)
    start = np.cos(np.arange(len(mass)))
    values, vectors = eigsh(stiffness, count, weight, sigma=SHIFT, OPinv=inverse, v0=start, tol=TOLERANCE)
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _cotangents(points: FloatArray, faces: IntArray) -> csc_array:
    count = len(points)
    double = 2.0 * np.linalg.norm(area_vectors(points, faces), axis=1)
    rows, columns, entries = [], [], []
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = (points[faces[:, corner]] - points[faces[:, a]] for corner in (b, c))
        dot = np.einsum("ij,ij->i", left, right)
        limit = LARGEST_COTANGENT * double
        half = 0.5 * np.clip(dot, -limit, limit) / np.where(double > 0.0, double, 1.0)
        rows += [faces[:, b], faces[:, c]]
        columns += [faces[:, c], faces[:, b]]
        entries += [half, half]
    both = np.concatenate(rows), np.concatenate(columns)
    weights = coo_array((np.concatenate(entries), both), shape=(count, count)).tocsc()
    return csc_array(diags_array(np.asarray(weights.sum(axis=1))) - weights)

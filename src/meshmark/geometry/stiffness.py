"""Piecewise linear finite elements on a triangle mesh: the stiffness matrix, and diffusion by it.

Source: Pinkall and Polthier, Computing discrete minimal surfaces and their conjugates (1993),
doi:10.1080/10586458.1993.10504266.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["diffused", "stiffness"]

# The cotangents of needle triangles are bounded by counting their area as at least this share of the mean.
LEAST_FACE = 1e-3
TOLERANCE = 1e-3
MOST_STEPS = 300
# Points at a time, so that what is made of them stays in the processor's cache.
BLOCK = 1 << 13
# Pairs of corners of a face.
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def stiffness(points: FloatArray, faces: IntArray, weights: FloatArray | None = None) -> sp.csr_array:
    """Return the matrix (p, p) of the integral of `weights` (m,), by face, times grad f . grad g."""
    twice = np.empty(len(faces))
    for part in blocks(len(faces)):
        _, one, other = _sides(points, faces[part])
        twice[part] = np.linalg.norm(np.cross(other, one), axis=1)
    twice = np.maximum(twice, LEAST_FACE * twice.mean())
    scale = 0.5 / twice if weights is None else 0.5 * weights / twice
    rows, columns = np.empty((2, len(_PAIRS), len(faces)), np.int32)
    values = np.empty(rows.shape)
    for part in blocks(len(faces)):
        sides = _sides(points, faces[part])
        for place, (i, j) in enumerate(_PAIRS):
            value = scale[part] * np.einsum("mi,mi->m", sides[i], sides[j])
            rows[place, part] = faces[part, i]
            columns[place, part] = faces[part, j]
            values[place, part] = value if i != j else 0.5 * value
    count = len(points)
    half = sp.csr_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))
    del rows, columns, values
    return sp.csr_array(half + half.T)


def _sides(points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sides (m, 3) of each face that lie opposite its corners."""
    a, b, c = (points.take(faces[:, i], axis=0) for i in range(3))
    return c - b, a - c, b - a


def diffused(
    values: FloatArray, mass: FloatArray, stiff: sp.csr_array, width: float, steps: int = 2
) -> FloatArray:
    """Return values (p, k) after diffusion to a Gaussian of this width, by `steps` implicit Euler steps.

    mass: (p,) lumped, above 0; stiff: from `stiffness`. Conjugate gradients, preconditioned by the diagonal.
    """
    matrix = sp.csr_array(sp.diags_array(mass) + width * width / (2.0 * steps) * stiff)
    inverse = 1.0 / matrix.diagonal()
    for _ in range(steps):
        values = _solved(matrix, mass[:, None] * values, values, inverse)
    return values


def _solved(matrix: sp.csr_array, target: FloatArray, start: FloatArray, inverse: FloatArray) -> FloatArray:
    """Solve matrix x = target (p, k) for all columns together, from a start."""
    columns = target.shape[1]
    here = start.copy()
    rest = np.ascontiguousarray(target - matrix @ here)
    limit = TOLERANCE * np.sqrt(np.einsum("pk,pk,p->k", target, target, inverse)) + 1e-300
    ahead = inverse[:, None] * rest
    along, strength = ahead.copy(), np.einsum("pk,pk->k", rest, ahead)
    # Entry by entry and block by block: numpy takes several times as long for rows of a few numbers.
    weights, size = np.repeat(inverse, columns), BLOCK * columns
    entries = [each.reshape(-1) for each in (here, rest, ahead, along)]
    for _ in range(MOST_STEPS):
        if (np.sqrt(strength) <= limit).all():
            break
        turned = matrix @ along
        length = np.tile(strength / np.maximum(np.einsum("pk,pk->k", along, turned), 1e-300), BLOCK)
        for part in blocks(rest.size, size):
            at, off, next_, way = (each[part] for each in entries)
            at += length[: len(way)] * way
            off -= length[: len(way)] * turned.reshape(-1)[part]
            np.multiply(weights[part], off, out=next_)
        previous, strength = strength, np.einsum("pk,pk->k", rest, ahead)
        turn = np.tile(strength / np.maximum(previous, 1e-300), BLOCK)
        for part in blocks(rest.size, size):
            _, _, next_, way = (each[part] for each in entries)
            way *= turn[: len(way)]
            way += next_
    return here

"""The discrete Gaussian on a mesh: heat kernels of the vertex random walk, all scales in one recurrence.

With the random walk W the Gaussian of scale alpha is `exp(-alpha (I - W))`, in Chebyshev polynomials
`e^-alpha [I_0(alpha) + 2 sum_n I_n(alpha) T_n(W)]`, I_n the modified Bessel functions. Only the coefficients
depend on alpha, so the T_n are computed once for any number of scales. On a path graph the kernel is the
paper's T(n, alpha) = e^-alpha I_n(alpha) (eq. 4-5; docs/design.md, section 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from meshmark.geometry.adjacency import adjacency
from meshmark.mesh import FloatArray, IntArray

try:  # what scipy itself multiplies with; called directly it adds onto an array instead of making a new one
    from scipy.sparse._sparsetools import csr_matvecs
except ImportError:  # it is private and may move
    csr_matvecs = None  # type: ignore[assignment]

__all__ = [
    "WalkWeights",
    "discrete_gaussian",
    "discrete_gaussian_sum",
    "random_walk",
    "spectral_filters",
    "terms",
    "walk_of",
]

WalkWeights = Literal["uniform", "inverse_length"]

TOLERANCE = 1e-12
FILTER_TERMS = 40
BLOCK = 9_000
"""Numbers that BLAS gets at a time: too few for it to wake its threads, which cost more than they give here."""


def random_walk(points: FloatArray, edges: IntArray, weights: WalkWeights = "uniform") -> csr_array:
    """Return W (p, p): row i holds the chances of a step from point i to each neighbour.

    weights: "uniform" (D^-1 Adj, the paper's) or "inverse_length" (a step is likelier the shorter its edge).
    A point without an edge stays where it is.
    """
    graph = adjacency(edges, len(points))
    if weights == "inverse_length":
        rows = np.repeat(np.arange(len(points)), np.diff(graph.indptr))
        steps = points.take(rows, axis=0) - points.take(graph.indices, axis=0)
        graph.data = 1.0 / np.maximum(np.sqrt(np.einsum("ij,ij->i", steps, steps)), np.finfo(float).tiny)
        return _walk(graph, graph.data, np.asarray(graph.sum(axis=1)))
    return walk_of(graph)


def walk_of(graph: csr_array) -> csr_array:
    """Return the uniform random walk (p, p) on a graph (p, p) with 1 for each edge, whose indices it shares."""
    return _walk(graph, graph.data, np.diff(graph.indptr))


def _walk(graph: csr_array, weights: FloatArray, total: FloatArray | IntArray) -> csr_array:
    degree = np.diff(graph.indptr)
    walk = csr_array((weights / np.repeat(total, degree), graph.indices, graph.indptr), shape=graph.shape)
    alone = degree == 0
    return csr_array(walk + diags_array(alone.astype(float))) if alone.any() else walk


def discrete_gaussian(
    walk: csr_array, values: FloatArray, alphas: ArrayLike, tolerance: float = TOLERANCE
) -> FloatArray:
    """Return (j, n, k): `values` (n, k) smoothed by `exp(-alpha (I - walk))` for each of j `alphas` >= 0.

    The neglected part of the series is at most `tolerance` times the size of `values` (in the degree-weighted
    norm, in which every T_n of a reversible walk has norm at most 1).
    """
    return _chebyshev_sums(walk, values, _coefficients(alphas, tolerance))


def discrete_gaussian_sum(
    walk: csr_array, values: FloatArray, alphas: ArrayLike, tolerance: float = TOLERANCE
) -> FloatArray:
    """Return (n, k): the sum of `discrete_gaussian` over the scales, for the cost of the largest one."""
    total = _coefficients(alphas, tolerance).sum(axis=0, keepdims=True)
    return _chebyshev_sums(walk, values, total).reshape(np.shape(values))


def spectral_filters(
    walk: csr_array,
    values: FloatArray,
    responses: Sequence[Callable[[FloatArray], FloatArray]],
    count: int = FILTER_TERMS,
) -> FloatArray:
    """Return (j, n, k): `values` (n, k) with each frequency x of the mesh multiplied by `response(x)`, j responses.

    A frequency is an eigenvalue of I - walk, in [0, 2]: 0 where neighbours agree. `discrete_gaussian` is the
    response exp(-alpha x). Smooth responses need few terms; one recurrence serves all.
    """
    nodes = chebpts1(count)
    samples = np.array([response(1.0 - nodes) for response in responses])
    # Interpolates at the nodes.
    factors = np.asarray(samples @ chebvander(nodes, count - 1), float) * (2.0 / count)
    factors[:, 0] /= 2.0
    return _chebyshev_sums(walk, values, factors)


def terms(alphas: ArrayLike, tolerance: float = TOLERANCE) -> int:
    """Return how many Chebyshev terms the scales need; one less is the number of sparse products."""
    return len(_coefficients(alphas, tolerance).T)


def _coefficients(alphas: ArrayLike, tolerance: float) -> FloatArray:
    """Return (j, terms): factors of T_0, T_1, ...; each row stops where what is left sums to < tolerance."""
    scales = np.atleast_1d(np.asarray(alphas, dtype=float))[:, None]
    beyond = int(8.5 * np.sqrt(scales.max())) + 16  # past here the series is below 1e-16 for any alpha
    # e^-alpha I_n(alpha) is the n-th Fourier coefficient of exp(alpha (cos t - 1)): ten times faster than ive.
    turn = np.arange(2 * beyond) * (np.pi / beyond)
    factors = np.fft.rfft(np.exp(scales * (np.cos(turn) - 1.0))).real[:, :beyond] / (2 * beyond)
    factors[:, 1:] *= 2.0
    tail = np.cumsum(factors[:, ::-1], axis=1)[:, ::-1]
    factors[tail < tolerance] = 0.0
    return factors[:, : int((factors != 0.0).any(axis=0).sum())]


def _chebyshev_sums(walk: csr_array, values: FloatArray, factors: FloatArray) -> FloatArray:
    """Return (j, n, k): `sum_m factors[j, m] T_m(walk) values`.

    The recurrence T_m+1 = 2 W T_m - T_m-1 is run on S_m = T_m, T_m, -T_m, -T_m, ... in turn: there it reads
    S_m+1 = S_m-1 -+ 2 W S_m, so each product is added onto the term before and needs no pass of its own.
    """
    before = np.array(values, dtype=np.float64, order="C")
    sums = np.multiply.outer(factors[:, 0], before)
    if factors.shape[1] == 1:
        return sums
    rows = list(sums.reshape(len(sums), -1))
    now = walk @ before
    _add_up(rows, now.reshape(-1), factors[:, 1].tolist())
    step = 2.0 * walk.data
    for m, column in enumerate(factors.T[2:].tolist()):
        np.negative(step, out=step)
        _add_product(walk, step, now, before)
        before, now = now, before
        _add_up(rows, now.reshape(-1), column if m % 4 > 1 else [-factor for factor in column])
    return sums


def _add_product(pattern: csr_array, data: FloatArray, values: FloatArray, onto: FloatArray) -> None:
    """`onto += A @ values` for the matrix A with `data` at the places of `pattern`; arrays (n, k) in C order."""
    if csr_matvecs is None:
        onto += csr_array((data, pattern.indices, pattern.indptr), shape=pattern.shape) @ values
    else:
        size = (*pattern.shape, values.shape[1])
        csr_matvecs(*size, pattern.indptr, pattern.indices, data, values.reshape(-1), onto.reshape(-1))


def _add_up(sums: list[FloatArray], term: FloatArray, factors: list[float]) -> None:
    """`sums[j] += factors[j] * term`, in blocks."""
    from scipy.linalg.blas import daxpy

    for total, factor in zip(sums, factors, strict=True):
        for start in range(0, term.size if factor else 0, BLOCK):
            block = slice(start, start + BLOCK)
            daxpy(term[block], total[block], a=factor)  # adds in place: both are float64 in a row

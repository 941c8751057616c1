"""Balanced power diagrams: semi-discrete optimal transport from a surface to a few seeds.

Point x belongs to the seed s_i with the least |x - s_i|^2 - w_i. The weights w that give every seed the same
mass minimise a convex function. It is softened by a temperature, solved by damped Newton steps, and the
temperature lowered until the cells are sharp. Of all partitions into equal masses the result is the most
compact one: it has the least sum of mass times squared distance to the seed.
"""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = ["assign", "balanced_weights", "condensed"]

CONDENSED = 6_000
"""Above this many points the weights are first solved on groups of neighbouring points."""
CHUNK = 1 << 15
"""Points whose distances to all seeds are held in memory at a time."""
COOLING = 0.3
NEWTON_STEPS = 8
POLISHING_STEPS = 24
FAIR = 1.001
"""Largest share over mean share at which polishing stops."""


ONE_PLACE = 1e-12
"""Extent of points, over that of the seeds, below which they are in one place."""


def assign(points: FloatArray, seeds: FloatArray, weights: FloatArray) -> IntArray:
    """Return (p,): for each point the index of the seed whose power cell it lies in."""
    level = np.einsum("ij,ij->i", seeds, seeds) - weights
    cells = np.empty(len(points), np.int64)
    for start in range(0, len(points), CHUNK):
        part = points[start : start + CHUNK]
        cells[start : start + CHUNK] = (level - 2.0 * (part @ seeds.T)).argmin(axis=1)
    return cells


def balanced_weights(points: FloatArray, masses: FloatArray, seeds: FloatArray) -> FloatArray:
    """Return (n,): weights whose power cells over `seeds` (n, 3) share the mass of `points` equally.

    masses: (p,) not negative, with a positive sum. A point is not divided, so the shares are equal up to
    about the mass of one point for each cell. Points that are all in about one place cannot be shared out: the
    weights are zeros.
    """
    masses = masses / masses.sum()
    size = float(np.ptp(points, axis=0).max()) or 1.0
    if size < ONE_PLACE * float(np.ptp(seeds, axis=0).max()):
        return np.zeros(len(seeds))
    points, seeds = points / size, seeds / size
    grouped, grouped_masses = condensed(points, masses)
    weights, stiffness = _anneal(grouped, grouped_masses, seeds)
    return _polish(points, masses, seeds, weights, stiffness) * size**2


def condensed(points: FloatArray, masses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return centres and masses of the points (p, 3) in each cube of a grid, where there are many."""
    if len(points) <= CONDENSED:
        return points, masses
    low = points.min(axis=0)
    across = int(np.sqrt(CONDENSED / 3.0))  # a surface meets about 3 across^2 of the cubes
    size = float(np.ptp(points, axis=0).max()) or 1.0
    cube = ((points - low) / size * across).astype(np.int64)
    key = (cube[:, 0] * (across + 1) + cube[:, 1]) * (across + 1) + cube[:, 2]
    _, group = np.unique(key, return_inverse=True)
    total = np.bincount(group, weights=masses).astype(np.float64)
    sums = [np.bincount(group, weights=masses * axis) for axis in points.T]
    kept = total > 0.0
    return np.stack(sums, axis=1)[kept] / total[kept, None], total[kept]


def _anneal(points: FloatArray, masses: FloatArray, seeds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the weights at the lowest temperature and the inverse of the Hessian there."""
    cost = np.einsum("pnk,pnk->pn", gap := points[:, None] - seeds, gap)
    cost -= cost.min(axis=1, keepdims=True)
    weights = np.zeros(len(seeds))
    temperature = float(masses @ cost.mean(axis=1)) or 1.0
    coldest = temperature * 0.1 / np.sqrt(len(points))  # about the step in cost from one point to the next
    stiffness = np.zeros((len(seeds), len(seeds)))
    while True:
        value, shares = _soft_value(cost, masses, weights, temperature)
        for _ in range(NEWTON_STEPS):
            excess, stiffness = _derivatives(shares, masses, temperature)
            before = weights
            for halving in range(8):  # the longest of a few steps that lowers the dual function
                tried = before - stiffness @ excess * 0.5**halving
                lower, tried_shares = _soft_value(cost, masses, tried, temperature)
                if lower < value:
                    weights, value, shares = tried, lower, tried_shares
                    break
            if weights is before or np.abs(excess).max() * len(seeds) < 1e-3:
                break
        if temperature <= coldest:
            return weights, stiffness
        temperature = max(temperature * COOLING, coldest)


def _soft_value(
    cost: FloatArray, masses: FloatArray, weights: FloatArray, temperature: float
) -> tuple[float, FloatArray]:
    """Return the dual function and the (p, n) shares of each point in each cell at a temperature."""
    scores = (weights - cost) / temperature
    top = scores.max(axis=1, keepdims=True)
    shares = np.exp(scores - top)
    sums = shares.sum(axis=1, keepdims=True)
    shares /= sums
    value = temperature * float(masses @ (top + np.log(sums))[:, 0]) - float(weights.mean())
    return value, shares


def _derivatives(shares: FloatArray, masses: FloatArray, temperature: float) -> tuple[FloatArray, FloatArray]:
    """Return gradient (excess of mass in each cell) and inverse Hessian of the dual function."""
    held = masses @ shares
    hessian = (np.diag(held) - (shares * masses[:, None]).T @ shares) / temperature
    hessian += np.eye(len(held)) * max(1e-9, 1e-6 * float(np.trace(hessian)) / len(held))
    stiffness = np.linalg.inv(hessian).astype(np.float64)
    return held - 1.0 / len(held), stiffness


def _polish(
    points: FloatArray, masses: FloatArray, seeds: FloatArray, weights: FloatArray, stiffness: FloatArray
) -> FloatArray:
    """Return the best weights seen while sharp cells of all points are balanced with the last Hessian."""
    best, best_peak, damping = weights, np.inf, 1.0
    start, home, lead = weights, *_cells_and_lead(points, seeds, weights)
    for _ in range(POLISHING_STEPS):
        loose = np.flatnonzero(lead <= 2.1 * np.abs(weights - start).max())  # the others stay in their cells
        cells = home.copy()
        cells[loose] = assign(points[loose], seeds, weights)
        held = np.bincount(cells, weights=masses, minlength=len(seeds))
        peak = float(held.max()) * len(seeds)
        if peak < best_peak:
            best, best_peak, excess = weights, peak, held - 1.0 / len(seeds)
        else:
            damping *= 0.5
        if best_peak <= FAIR:
            break
        weights = best - damping * (stiffness @ excess)
    return best


def _cells_and_lead(
    points: FloatArray, seeds: FloatArray, weights: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return (p,) each: as `assign` does, and by how much the next seed is worse."""
    cells, lead = assign(points, seeds, weights), np.full(len(points), np.inf)
    if len(seeds) > 1:
        level = np.einsum("ij,ij->i", seeds, seeds) - weights
        for first in range(0, len(points), CHUNK):
            least = np.partition(level - 2.0 * (points[first : first + CHUNK] @ seeds.T), 1, axis=1)
            lead[first : first + CHUNK] = least[:, 1] - least[:, 0]
    return cells, lead

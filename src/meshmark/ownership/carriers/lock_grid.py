"""The grid over a ball of corrections, and the best places of all its points by one matrix product.

A grid point is the sum of one in some of the directions and one in the others; its wave is the product of theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gamma

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "MOST",
    "SLACK",
    "Grid",
    "Waves",
    "best_places",
    "distinguished",
    "grid_size",
    "plan_grid",
    "spread_of",
]

# Spacing of the grid in each direction, in radians (RMS over cells). Half of that in
# seven directions leaves a score of about 0.6 of the peak's.
GRID = 1.3
# Grid points at most, where the caller does not say.
MOST = 12_000
ROWS, COLUMNS = 128, 8192
ROUNDING = 1e-9
# To bound the chance of a maximum that was polished, the ball is thought of as covered by a grid finer by this in
# each direction, on which the score is within 3 % of its maximum.
FINER = 4.0
# Polishing may lead out of the ball, up to this number of times its radius.
SLACK = 1.3


@dataclass(frozen=True, eq=False, kw_only=True)
class _Half:
    """Grid points in some of the directions, nearest first: places (q, d), distances (q,), waves (q, n)."""

    places: FloatArray
    distances: FloatArray
    waves: NDArray[np.complex64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """All sums of a point of one half and one of the other within the radius; `size` of them."""

    halves: tuple[_Half, _Half]
    radius: float
    size: int


def distinguished(grid: Grid, response: FloatArray) -> float:
    """Return how many independent corrections the best of a grid, polished, is the best of, at most."""
    return float(grid.size * (FINER * SLACK) ** response.shape[1])


def grid_size(response: FloatArray, radius: float) -> float:
    """Return how many independent corrections a ball holds, at most, for cells of this response (n, d).

    response: change of the phases per standard deviation of each part; radius: in standard deviations.
    """
    squares = np.linalg.eigvalsh(response.T @ response / len(response))
    points = _points(np.sqrt(np.maximum(squares, 0.0)), radius)[0]
    return float(points * (FINER * SLACK) ** len(squares))


def _points(spread: FloatArray, radius: float) -> tuple[float, IntArray]:
    """Return about how many grid points a ball holds, and how far it reaches in each direction."""
    reach = np.floor(radius * spread / GRID + 0.5).astype(np.int64)
    # A ball fills less and less of its cube: 0.16 in four directions, 0.037 in seven.
    active = int((reach > 0).sum())
    filled = np.pi ** (active / 2) / gamma(active / 2 + 1) / 2.0**active
    return float(np.prod(2.0 * reach + 1.0) * filled), reach


class Waves:
    """The waves of grid points along single directions: the same whatever the step is that scales the response."""

    def __init__(self, response: FloatArray, spread: FloatArray) -> None:
        self._response, self._spread = response, spread
        self._known: dict[int, NDArray[np.complex64]] = {}

    @property
    def count(self) -> int:
        """The number of phases, n."""
        return len(self._response)

    def along(self, direction: int, reach: int) -> NDArray[np.complex64]:
        """Return those (2 reach + 1, n) of the points from -reach to reach along a direction."""
        known = self._known.get(direction)
        if known is None or len(known) < 2 * reach + 1:
            turn = np.arange(-reach, reach + 1) * (GRID / self._spread[direction])
            known = np.exp(1j * np.outer(turn, self._response[:, direction])).astype(np.complex64)
            self._known[direction] = known
        middle = len(known) // 2
        return known[middle - reach : middle + reach + 1]


def spread_of(response: FloatArray, weight: FloatArray) -> FloatArray:
    """Return (d,): the RMS response of weighted phases to each direction."""
    return np.asarray(np.sqrt(weight**2 @ response**2 / (weight @ weight)))


def plan_grid(
    response: FloatArray, weight: FloatArray, radius: float, most: int, waves: Waves | None = None
) -> Grid:
    """Lay the grid over the ball; shrink the ball until the points are few enough."""
    spread = spread_of(response, weight)
    waves = Waves(response, spread) if waves is None else waves
    while True:
        points, reach = _points(spread, radius)
        if points <= most:
            break
        radius *= 0.95
    order = np.argsort(-reach, kind="stable")
    # Dealt out 1 2 2 1 1 2 2 1 by their number of points, the directions make halves of about equal size.
    first = (np.arange(len(order)) + 1) // 2 % 2 == 0
    one, two = (_lay(waves, spread, reach, order[side], radius) for side in (first, ~first))
    size = int(np.searchsorted(two.distances, _leg(radius, one.distances), side="right").sum())
    return Grid(halves=(one, two), radius=radius, size=size)


def _lay(waves: Waves, spread: FloatArray, reach: IntArray, directions: IntArray, radius: float) -> _Half:
    """Return the grid over some directions, within the radius, nearest first."""
    active = directions[reach[directions] > 0]
    spacing = GRID / spread[active]
    squares, product = np.zeros(1), None
    ticks = np.zeros((1, 0), dtype=np.int64)
    for i, d in zip(active, spacing, strict=True):
        tick = np.arange(-reach[i], reach[i] + 1)
        within = squares[:, None] + (tick * d) ** 2
        row, column = np.nonzero(within <= radius * radius)
        squares = within[row, column]
        if i == active[-1]:  # in order before what costs most, the waves of all points
            order = np.argsort(squares, kind="stable")
            row, column, squares = row[order], column[order], squares[order]
        ticks = np.column_stack([ticks[row], tick[column]])
        # Few ticks, many points: a product is cheaper than an exponential.
        along = waves.along(int(i), int(reach[i]))[column]
        product = along if product is None else product[row] * along
    places = np.zeros((len(ticks), len(spread)))
    places[:, active] = ticks * spacing
    if product is None:  # the middle alone
        product = np.ones((1, waves.count), dtype=np.complex64)
    return _Half(places=places, distances=np.sqrt(squares), waves=product)


def _leg(radius: float, other: FloatArray) -> FloatArray:
    """Return how far the other half may be from 0 where this one is `other` away."""
    return np.sqrt(np.maximum(radius * radius * (1.0 + ROUNDING) - other * other, 0.0))


def best_places(grid: Grid, psi: FloatArray, weight: FloatArray, keep: int) -> list[FloatArray]:
    """Return the places (d,) of the best scores, each score less the square of its distance."""
    one, two = grid.halves
    start = one.waves * (weight * np.exp(1j * psi)).astype(np.complex64)
    # Squared distances from 0 are taken off within the product, by two more columns.
    near, far = np.float32(one.distances[:, None] ** 2), np.float32(two.distances[:, None] ** 2)
    rows = np.hstack([start.real, -start.imag, -near, -np.ones_like(near)])
    columns = np.ascontiguousarray(np.hstack([two.waves.real, two.waves.imag, np.ones_like(far), far]).T)
    ends = np.searchsorted(two.distances, _leg(grid.radius, one.distances), side="right")
    found: list[tuple[float, int, int]] = []
    for i in range(0, len(rows), ROWS):
        within = ends[i : i + ROWS]
        for j in range(0, int(within[0]), COLUMNS):
            ahead = np.arange(j, min(j + COLUMNS, int(within[0])))
            worth = rows[i : i + ROWS] @ columns[:, j : j + len(ahead)]
            if ahead[-1] >= within[-1]:  # some rows end before
                worth[ahead >= within[:, None]] = -np.inf
            best = worth.argmax(axis=1)  # neighbours of a peak climb the same one: one for each row is enough
            top = worth[np.arange(len(best)), best]
            found += zip(top.tolist(), range(i, i + len(best)), (j + best).tolist(), strict=True)
        found = sorted(found, reverse=True)[:keep]
    return [one.places[a] + two.places[b] for _, a, b in found]

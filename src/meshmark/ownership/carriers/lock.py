"""Lattice lock: the correction under which the cells' offsets lie on the quantiser's points.

The score sum_k w_k cos(psi_k + g_k . y), psi the phases of pilots and twice those of the other cells, does not
depend on the message and peaks at the true correction y (docs/design.md, section 4). As exp(i (a + b)) = exp(i a)
exp(i b), the scores of all corrections (y1, y2) are *one matrix product*, of the waves of all y1 with those of all
y2: a million corrections cost a few milliseconds. So a grid over a ball in seven or more dimensions is searched
whole, with no risk of missing a peak, and only the best places are polished.

Corrections are measured in units of what is expected of them (a standard deviation is 1) along the principal
directions of the phases' response, so that ill-determined directions get few grid points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gamma

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.weighted_squares import WeightedSquares

__all__ = ["Lock", "LockSearch", "grid_size"]

# Spacing of the grid in each direction, in radians (RMS over cells). Half of that in
# seven directions leaves a score of about 0.6 of the peak's.
GRID = 1.3
# Grid points at most, where the caller does not say.
MOST = 12_000
ROWS, COLUMNS = 128, 8192
ROUNDING = 1e-9
POLISH_STEPS = 8
# To bound the chance of a maximum that was polished, the ball is thought of as covered by a grid finer by this in
# each direction, on which the score is within 3 % of its maximum.
FINER = 4.0
# Polishing may lead out of the ball, up to this number of times its radius.
SLACK = 1.3


@dataclass(frozen=True, eq=False, kw_only=True)
class Lock:
    """A correction and how well it fits.

    correction: (d,) in the units of the gradient's columns.
    score: weighted sum of cosines there; tried: how many independent corrections this is the best of, at most.
    """

    correction: FloatArray
    score: float
    tried: float


class LockSearch:
    """The search for corrections of one set of phases.

    psi: (n,) phases that do not depend on bits, radians; gradient: (n, d) their change per unit of each part of the
    correction; expected: (d,) standard deviation of each part; radius: of the ball searched, in these.
    most: grid points at most; where there were more, the ball shrinks. weight: (n,) what each phase counts, squares
    of mean 1.
    """

    def __init__(
        self,
        psi: FloatArray,
        gradient: FloatArray,
        expected: FloatArray,
        radius: float,
        most: int = MOST,
        *,
        weight: FloatArray,
    ) -> None:
        response = gradient * expected
        weighted = response * weight[:, None]
        _, turn = np.linalg.eigh(weighted.T @ weighted)
        self._weight = weight
        self._psi, self._response, self._back = psi, response @ turn, expected[:, None] * turn
        self._grid = _plan(self._response, weight, radius, most)

    @property
    def tried(self) -> float:
        """How many independent corrections the best of this search is the best of, at most."""
        return float(self._grid.size * (FINER * SLACK) ** self._response.shape[1])

    def rough(self, keep: int) -> list[Lock]:
        """Return the best grid points, best first, one at most of each row of the grid.

        A correction far from 0 is expected less: its score must be better by the square of its distance.
        """
        return [self._lock(place) for place in _best_places(self._grid, self._psi, self._weight, keep)]

    def polished(self, rough: Sequence[Lock]) -> list[Lock]:
        """Return the top of the score next to each grid point; the point where that is far out of the ball."""
        if not rough:
            return []
        starts = np.linalg.solve(self._back, np.array([lock.correction for lock in rough]).T).T
        places = _polish(self._psi, self._response, self._weight, starts)
        inside = np.linalg.norm(places, axis=1) <= self._grid.radius * SLACK
        return [
            self._lock(place) if near else lock
            for lock, place, near in zip(rough, places, inside, strict=True)
        ]

    def _lock(self, place: FloatArray) -> Lock:
        score = float(np.cos(self._psi + self._response @ place) @ self._weight)
        return Lock(correction=self._back @ place, score=score, tried=self.tried)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Half:
    """Grid points in some of the directions, nearest first: places (q, d), distances (q,), waves (q, n)."""

    places: FloatArray
    distances: FloatArray
    waves: NDArray[np.complex64]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Grid:
    """All sums of a point of one half and one of the other within the radius; `size` of them."""

    halves: tuple[_Half, _Half]
    radius: float
    size: int


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


def _plan(response: FloatArray, weight: FloatArray, radius: float, most: int) -> _Grid:
    """Lay the grid over the ball; shrink the ball until the points are few enough."""
    spread = np.sqrt(weight**2 @ response**2 / (weight @ weight))
    while True:
        points, reach = _points(spread, radius)
        if points <= most:
            break
        radius *= 0.95
    order = np.argsort(-reach, kind="stable")
    # Dealt out 1 2 2 1 1 2 2 1 by their number of points, the directions make halves of about equal size.
    first = (np.arange(len(order)) + 1) // 2 % 2 == 0
    one, two = (_lay(response, spread, reach, order[side], radius) for side in (first, ~first))
    size = int(np.searchsorted(two.distances, _leg(radius, one.distances), side="right").sum())
    return _Grid(halves=(one, two), radius=radius, size=size)


def _lay(
    response: FloatArray, spread: FloatArray, reach: IntArray, directions: IntArray, radius: float
) -> _Half:
    """Return the grid over some directions, within the radius, nearest first."""
    active = directions[reach[directions] > 0]
    spacing = GRID / spread[active]
    squares, waves = np.zeros(1), np.ones((1, len(response)), dtype=np.complex64)
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
        waves = waves[row] * np.exp(1j * np.outer(tick * d, response[:, i])).astype(np.complex64)[column]
    places = np.zeros((len(ticks), len(spread)))
    places[:, active] = ticks * spacing
    return _Half(places=places, distances=np.sqrt(squares), waves=waves)


def _leg(radius: float, other: FloatArray) -> FloatArray:
    """Return how far the other half may be from 0 where this one is `other` away."""
    return np.sqrt(np.maximum(radius * radius * (1.0 + ROUNDING) - other * other, 0.0))


def _best_places(grid: _Grid, psi: FloatArray, weight: FloatArray, keep: int) -> list[FloatArray]:
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


def _polish(psi: FloatArray, response: FloatArray, weight: FloatArray, places: FloatArray) -> FloatArray:
    """Climb to the top of the score from each place (k, d) by damped Newton steps; return the ends (k, d)."""
    here, damping = places.copy(), np.full(len(places), 1e-2)
    phase = psi + here @ response.T
    cosine = np.cos(phase)
    score = cosine @ weight
    climbing = np.arange(len(places))
    squares = WeightedSquares(response)
    diagonal = np.arange(response.shape[1])
    for _ in range(POLISH_STEPS):
        # Where a cosine is low its curvature points the wrong way; it is left out.
        hessian = squares(weight * np.maximum(cosine[climbing], 0.0))
        # An expected step of 1 holds ill-determined ones.
        hessian[:, diagonal, diagonal] += hessian[:, diagonal, diagonal] * damping[climbing, None] + 1.0
        slope = (weight * np.sin(phase[climbing])) @ response
        ahead = here[climbing] + np.linalg.solve(hessian, -slope[..., None])[..., 0]
        moved = psi + ahead @ response.T
        there = np.cos(moved)
        better = there @ weight
        up = better > score[climbing]
        rows, gain = climbing[up], (better - score[climbing])[up]
        damping[climbing[~up]] *= 10.0
        damping[rows] *= 0.3
        here[rows], phase[rows], cosine[rows], score[rows] = ahead[up], moved[up], there[up], better[up]
        climbing = np.setdiff1d(climbing, rows[gain < 1e-3 * np.abs(score[rows])], assume_unique=True)
        if not len(climbing):
            break
    return here

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

__all__ = ["Lock", "LockSearch", "StepSearch", "grid_size"]

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
        turn = _directions(response, weight)
        self._weight = weight
        self._psi, self._response, self._back = psi, response @ turn, expected[:, None] * turn
        self._grid = _plan(self._response, weight, radius, most)

    @property
    def tried(self) -> float:
        """How many independent corrections the best of this search is the best of, at most."""
        return _distinguished(self._grid, self._response)

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
        psi, scale = np.tile(self._psi, (len(rough), 1)), np.ones(len(rough))
        places = _polish(psi, self._response, self._weight, starts, scale)
        inside = np.linalg.norm(places, axis=1) <= self._grid.radius * SLACK
        return [
            self._lock(place) if near else lock
            for lock, place, near in zip(rough, places, inside, strict=True)
        ]

    def _lock(self, place: FloatArray) -> Lock:
        score = float(np.cos(self._psi + self._response @ place) @ self._weight)
        return Lock(correction=self._back @ place, score=score, tried=self.tried)


class StepSearch:
    """The search for corrections of cells that are read with several quantisation steps, all at once.

    psi: (s, n) phases that do not depend on bits, radians, for each of the steps (s,); gradient: (n, d) their change
    per unit of each part of the correction at a step of 1. expected, radius, weight: as in `LockSearch`.
    """

    def __init__(
        self,
        psi: FloatArray,
        gradient: FloatArray,
        steps: Sequence[float],
        expected: FloatArray,
        radius: float,
        *,
        weight: FloatArray,
    ) -> None:
        response = gradient * expected
        turn = _directions(response, weight)
        self._psi, self._steps, self._weight = psi, np.array(steps), weight
        self._response, self._back = response @ turn, expected[:, None] * turn
        waves = _Waves(self._response, _spread(self._response, weight))
        self._grids = [_plan(self._response / step, weight, radius, MOST, waves) for step in steps]

    @property
    def tried(self) -> float:
        """How many independent corrections the best of this search is the best of, at most, all steps together."""
        return sum(_distinguished(grid, self._response) for grid in self._grids)

    def best(self, keep: int, polished: int) -> list[tuple[float, Lock]]:
        """Return steps and locks, best first: the tops next to the best grid points of all steps.

        keep: grid points of each step; polished: of them all.
        """
        found = [
            (row, place)
            for row, (psi, grid) in enumerate(zip(self._psi, self._grids, strict=True))
            for place in _best_places(grid, psi, self._weight, keep)
        ]
        rows, starts = np.array([row for row, _ in found]), np.array([place for _, place in found])
        first = np.argsort(-self._scores(rows, starts), kind="stable")[:polished]
        rows, starts = rows[first], starts[first]
        ends = _polish(self._psi[rows], self._response, self._weight, starts, 1.0 / self._steps[rows])
        reach = np.array([self._grids[row].radius for row in rows]) * SLACK
        places = np.where((np.linalg.norm(ends, axis=1) <= reach)[:, None], ends, starts)
        scores = self._scores(rows, places)
        return [
            (
                float(self._steps[rows[i]]),
                Lock(correction=self._back @ places[i], score=float(scores[i]), tried=self.tried),
            )
            for i in np.argsort(-scores, kind="stable")
        ]

    def _scores(self, rows: IntArray, places: FloatArray) -> FloatArray:
        moved = (places / self._steps[rows, None]) @ self._response.T
        return np.asarray(np.cos(self._psi[rows] + moved) @ self._weight)


def _directions(response: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the principal directions (d, d), in columns, of the response (n, d) of weighted phases."""
    weighted = response * weight[:, None]
    return np.asarray(np.linalg.eigh(weighted.T @ weighted)[1])


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


def _distinguished(grid: _Grid, response: FloatArray) -> float:
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


class _Waves:
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


def _spread(response: FloatArray, weight: FloatArray) -> FloatArray:
    """Return (d,): the RMS response of weighted phases to each direction."""
    return np.asarray(np.sqrt(weight**2 @ response**2 / (weight @ weight)))


def _plan(
    response: FloatArray, weight: FloatArray, radius: float, most: int, waves: _Waves | None = None
) -> _Grid:
    """Lay the grid over the ball; shrink the ball until the points are few enough."""
    spread = _spread(response, weight)
    waves = _Waves(response, spread) if waves is None else waves
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
    return _Grid(halves=(one, two), radius=radius, size=size)


def _lay(
    waves: _Waves, spread: FloatArray, reach: IntArray, directions: IntArray, radius: float
) -> _Half:
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


def _polish(
    psi: FloatArray, response: FloatArray, weight: FloatArray, places: FloatArray, scale: FloatArray
) -> FloatArray:
    """Climb to the top of each score from each place (k, d) by damped Newton steps; return the ends (k, d).

    psi: (k, n) the phases at 0; scale: (k,) what the response (n, d) is to be multiplied by for each.
    """
    here, damping = places.copy(), np.full(len(places), 1e-2)
    factor = scale[:, None]
    phase = psi + factor * (here @ response.T)
    cosine = np.cos(phase)
    score = cosine @ weight
    climbing = np.arange(len(places))
    squares = WeightedSquares(response)
    diagonal = np.arange(response.shape[1])
    for _ in range(POLISH_STEPS):
        # Where a cosine is low its curvature points the wrong way; it is left out.
        hessian = squares(weight * np.maximum(cosine[climbing], 0.0)) * factor[climbing, :, None] ** 2
        # An expected step of 1 holds ill-determined ones.
        hessian[:, diagonal, diagonal] += hessian[:, diagonal, diagonal] * damping[climbing, None] + 1.0
        slope = factor[climbing] * ((weight * np.sin(phase[climbing])) @ response)
        ahead = here[climbing] + np.linalg.solve(hessian, -slope[..., None])[..., 0]
        moved = psi[climbing] + factor[climbing] * (ahead @ response.T)
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

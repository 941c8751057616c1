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

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lock_grid import (
    MOST,
    SLACK,
    Waves,
    best_places,
    distinguished,
    plan_grid,
    spread_of,
)
from meshmark.ownership.carriers.weighted_squares import WeightedSquares

__all__ = ["Lock", "LockSearch", "StepSearch"]

POLISH_STEPS = 8


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
        self._grid = plan_grid(self._response, weight, radius, most)

    @property
    def tried(self) -> float:
        """How many independent corrections the best of this search is the best of, at most."""
        return distinguished(self._grid, self._response)

    def at_rest(self) -> Lock:
        """Return the lock without any correction."""
        return self._lock(np.zeros(len(self._back)))

    def rough(self, keep: int) -> list[Lock]:
        """Return the best grid points, best first, one at most of each row of the grid.

        A correction far from 0 is expected less: its score must be better by the square of its distance.
        """
        return [self._lock(place) for place in best_places(self._grid, self._psi, self._weight, keep)]

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

    psi: (s, n) phases that do not depend on bits, radians, for each of the steps (s,); gradient: (n, d) their
    change per unit of each part of the correction at a step of 1. expected, radius, weight: as in `LockSearch`.
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
        waves = Waves(self._response, spread_of(self._response, weight))
        self._grids = [plan_grid(self._response / step, weight, radius, MOST, waves) for step in steps]

    @property
    def tried(self) -> float:
        """How many independent corrections the best of this search is the best of, at most, all steps together."""
        return sum(distinguished(grid, self._response) for grid in self._grids)

    def best(self, keep: int, polished: int) -> list[tuple[float, Lock]]:
        """Return steps and locks, best first: the tops next to the best grid points of all steps.

        keep: grid points of each step; polished: of them all.
        """
        found = [
            (row, place)
            for row, (psi, grid) in enumerate(zip(self._psi, self._grids, strict=True))
            for place in best_places(grid, psi, self._weight, keep)
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

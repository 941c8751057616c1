"""The lattice lock on measured shapes: the correction of the frame that puts the cells on the quantiser's points.

What the strategies share that correct a frame: a search of the whole ball of likely corrections (`locked`), and
growth from a cluster of cells where the frame is off by more (`grown_readings`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isclose

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.grown_lock import grown, neighbourhood
from meshmark.ownership.carriers.lock import LockSearch, StepSearch
from meshmark.ownership.carriers.quantisation import log10_lock_chance
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_MOST,
    CARRIER_READABLE,
    CREDIBLE_LOG10,
    LOCK_CANDIDATES,
    LOCK_EXPECTED,
    LOCK_PEAKS,
    LOCK_POLISHED,
    LOCK_RADIUS,
    TYPICAL_STEP,
)
from meshmark.ownership.search.measurement import CellReading, Measurement
from meshmark.ownership.search.shapes import Hypothesis, Response, Shapes

__all__ = ["grown_locks", "grown_readings", "locked_readings", "relocked"]

# Peaks of one step whose scores differ by less than this share are the same.
SAME_PEAK = 1e-3
# Corrections tried in the first cluster: twelve directions need more than seven.
STRETCH_GRID = 1_000_000


def locked_readings(
    shapes: Shapes, hypothesis: Hypothesis, steps: Sequence[float], charge: float
) -> Iterator[Reading]:
    """Yield the best corrections over all steps; after one that is credible, also what is measured there anew.

    charge: of this trial (`TrialCounter`); each reading pays for the corrections of all steps besides.
    """
    response = shapes.response(hypothesis)
    if not CARRIER_READABLE <= len(response) <= CARRIER_MOST:
        return
    expected = np.concatenate([LOCK_EXPECTED, hypothesis.restoration.expected])
    measured = response.measured
    search = StepSearch(
        np.stack([measured.psi(step) for step in steps]),
        measured.turn(response.gradient, 1.0),
        steps,
        expected,
        LOCK_RADIUS,
        weight=measured.keys.weight,
    )
    tried = search.tried
    found = [(lock.score, step, lock.correction) for step, lock in search.best(LOCK_PEAKS, LOCK_POLISHED)]
    for score, step, correction in _distinct(found)[:LOCK_CANDIDATES]:
        phase = measured.phase(step, response.gradient @ correction)
        yield CellReading.of(measured, step, phase, charge * tried)
        if log10_lock_chance(score, len(phase)) + np.log10(tried) < CREDIBLE_LOG10:
            yield _again(shapes.corrected(hypothesis, correction), step, charge * tried)


def _distinct(found: list[tuple[float, float, FloatArray]]) -> list[tuple[float, float, FloatArray]]:
    """Return those of some (score, step, correction), best first, that are not the peak of a better one."""
    kept: list[tuple[float, float, FloatArray]] = []
    for entry in found:
        if all(entry[1] != other[1] or not isclose(entry[0], other[0], rel_tol=SAME_PEAK) for other in kept):
            kept.append(entry)
    return kept


def grown_readings(
    shapes: Shapes, hypothesis: Hypothesis, steps: Sequence[float], drift: float, charge: float
) -> Iterator[Reading]:
    """Yield what locks from a first cluster of cells on.

    drift: expected deviation of the frame, over the usual one; charge: of this trial.
    """
    response = shapes.response(hypothesis)
    if not CARRIER_READABLE <= len(response) <= CARRIER_MOST:
        return
    expected = np.concatenate([LOCK_EXPECTED * drift, hypothesis.restoration.expected])
    places = response.measured.cells.nodes.astype(np.float64)
    typical = response.measured.turn(response.gradient, TYPICAL_STEP)
    order = neighbourhood(typical * expected, places, response.measured.keys.weight)
    for step, correction, tried in grown_locks(response, expected, steps, order, STRETCH_GRID):
        yield _again(shapes.corrected(hypothesis, correction), step, charge * tried)


def grown_locks(
    response: Response,
    expected: FloatArray,
    steps: Sequence[float],
    order: IntArray,
    most: int,
) -> Iterator[tuple[float, FloatArray, float]]:
    """Yield (step, correction (d,), hypotheses tried) of each credible lock that grows from the first cluster.

    expected, order, most: as in `grown`.
    """
    measured = response.measured
    for step in steps:
        psi = measured.psi(step)
        turn = measured.turn(response.gradient, step)
        lock = grown(psi, turn, expected, order, most, weight=measured.keys.weight)
        if lock is None:
            continue
        tried = lock.tried * len(steps)
        if log10_lock_chance(lock.score, len(psi)) + np.log10(tried) < CREDIBLE_LOG10:
            yield step, lock.correction, tried


def relocked(
    measured: Measurement, gradient: FloatArray, step: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return (phases (n,) after it, best correction (7,) close to where the cells were measured, tried)."""
    search = LockSearch(
        measured.psi(step),
        measured.turn(gradient, step),
        LOCK_EXPECTED,
        LOCK_RADIUS,
        weight=measured.keys.weight,
    )
    correction = search.polished(search.rough(1))[0].correction
    return measured.phase(step, gradient @ correction), correction, search.tried


def _again(response: Response, step: float, charge: float) -> Reading:
    """Return the best reading close to where this response was measured."""
    phase, _, tried = relocked(response.measured, response.gradient, step)
    return CellReading.of(response.measured, step, phase, charge * tried)

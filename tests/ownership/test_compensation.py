"""How far each cell goes towards its quantiser's point."""

from __future__ import annotations

import numpy as np

from meshmark.ownership.compensation import Compensation, Task

RANDOM = np.random.default_rng(5)
STEP, COUNT = 0.1, 120
CHANGE = RANDOM.uniform(-0.5, 0.5, COUNT) * STEP


def compensated(allowed: np.ndarray) -> Compensation:
    """Return the compensation where each cell may change its offset by `allowed` (n,) before it shows."""

    def seen(change):
        ratio = np.abs(change) / allowed
        return ratio, float((ratio > 1.0).mean())

    task = Task(
        change=CHANGE,
        step=STEP,
        cost=np.eye(COUNT),
        locks=np.ones(COUNT, dtype=bool),
        seen=seen,
        share=0.02,
    )
    return Compensation.of(task)


def test_what_is_not_seen_goes_the_whole_way():
    found = compensated(np.full(COUNT, 10.0))
    np.testing.assert_allclose(found.change, CHANGE, atol=0.01 * STEP)
    assert found.told > 0.999


def test_no_cell_goes_further_than_is_seen_but_a_few():
    allowed = RANDOM.uniform(0.1, 0.5, COUNT) * STEP
    found = compensated(allowed)
    assert (np.abs(found.change) > 1.02 * allowed).mean() < 0.05
    assert 0.5 < found.told < 1.0


def test_a_mark_that_may_be_seen_more_tells_more():
    told = [compensated(np.full(COUNT, share * STEP)).told for share in (0.1, 0.2, 0.4)]
    assert told == sorted(told)
    assert told[2] > told[0] + 0.05


def test_no_cells_no_change():
    empty = np.zeros(0)
    task = Task(
        change=empty,
        step=STEP,
        cost=np.zeros((0, 0)),
        locks=np.zeros(0, dtype=bool),
        seen=lambda change: (change, 0.0),
        share=0.02,
    )
    assert Compensation.of(task).change.shape == (0,)

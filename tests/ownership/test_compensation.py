"""How far each cell goes towards its quantiser's point."""

from __future__ import annotations

import numpy as np
import pytest

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
    np.testing.assert_allclose(found.change, CHANGE, atol=0.04 * STEP)
    assert found.cosine.min() > 0.97


def test_cells_go_as_far_as_they_may_and_no_further():
    allowed = RANDOM.uniform(0.1, 0.5, COUNT) * STEP
    found = compensated(allowed)
    gone = np.abs(found.change)
    assert (gone > 1.02 * allowed).mean() < 0.05
    assert gone.mean() > 0.9 * np.minimum(np.abs(CHANGE), allowed).mean()


@pytest.mark.parametrize("share", [0.15, 0.2, 0.3, 0.4])
def test_no_other_changes_within_the_limit_tell_more(share):
    found = compensated(np.full(COUNT, share * STEP))
    left = np.maximum(np.abs(CHANGE) - share * STEP, 0.0)
    assert found.cosine.mean() > 0.97 * np.cos(2.0 * np.pi * left / STEP).mean()


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

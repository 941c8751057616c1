"""Steps beside the nearest that spare the frame a correction."""

from __future__ import annotations

import numpy as np

from meshmark.ownership.points.balance import balanced
from meshmark.ownership.points.coordinates import held

COUNT, STEP = 40, 0.01


def problem(seed: int):
    """Return what `balanced` is given, of a frame whose correction is dear."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(COUNT, 3, 3))
    ease = root @ root.transpose(0, 2, 1) + 0.2 * np.eye(3)
    carries = random.random((COUNT, 3)) < 0.5
    follow, _ = held(ease, carries)
    motion = np.einsum("pij,pj->pi", follow, STEP * random.uniform(-0.5, 0.5, (COUNT, 3)))
    gradient = random.normal(size=(9, COUNT, 3))
    price = 4.0 * np.eye(9)
    return {
        "motion": motion, "follow": follow, "cost": np.linalg.inv(ease), "carries": carries, "step": STEP,
        "gradient": gradient, "error": 0.3 * random.normal(size=9), "price": price,
    }  # fmt: skip


def energy(given, motion):
    """Return the energy of motions (p, 3) and of the correction that the frame then needs."""
    error = given["error"] + np.einsum("qpi,pi->q", given["gradient"], motion - given["motion"])
    own = np.einsum("pi,pij,pj->", motion, given["cost"], motion)
    return own + error @ given["price"] @ error


def test_the_energy_falls():
    for seed in range(5):
        given = problem(seed)
        motion = balanced(**given)
        assert energy(given, motion) < energy(given, given["motion"])


def test_coordinates_move_by_whole_steps_each_point_once():
    given = problem(7)
    before = given["motion"].copy()
    change = (balanced(**given) - before) / STEP
    steps = np.abs(change[given["carries"]])
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert steps.max() <= 1.0 + 1e-9
    per_point = np.where(given["carries"], np.round(np.abs(change)), 0.0).sum(axis=1)
    assert per_point.max() == 1.0
    np.testing.assert_array_equal(given["motion"], before)


def test_nothing_changes_where_a_step_saves_nothing():
    given = problem(3) | {"error": np.zeros(9)}
    small = given | {"motion": 1e-6 * given["motion"]}
    np.testing.assert_array_equal(balanced(**small), small["motion"])
    none = problem(3) | {"carries": np.zeros((COUNT, 3), bool)}
    np.testing.assert_array_equal(balanced(**none), none["motion"])

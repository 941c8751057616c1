"""The label map is what linear discriminants of planted data are, and drifts are what they say."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.geometry.invariants import INVARIANTS, shape_invariants
from meshmark.mesh import Mesh
from meshmark.research.training.label_training import collision, fit_label_map
from meshmark.research.training.label_trials import ATTACKED, Drift, drifts
from tests.counting import some
from tests.shapes import pebble

COUNT = len(INVARIANTS)
# What attacks hardly move, among 16 directions none of which is an axis.
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(COUNT, COUNT)))[0]
QUIET = 3


def planted(seed: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Models of unit variance in every direction; drifts that spare QUIET directions, in the last of 4 rows."""
    rng = np.random.default_rng(seed)
    models = rng.normal(size=(900, COUNT)) @ TURN.T
    scale = np.where(np.arange(COUNT) < QUIET, 0.01, 0.3)
    true = [scale * rng.normal(size=COUNT) @ TURN.T for _ in range(400)]
    return models, [np.vstack([rng.normal(size=(3, COUNT)), row]) for row in true]


def test_the_map_finds_the_directions_that_attacks_spare():
    models, changes = planted(0)
    matrix = fit_label_map(models, changes, QUIET, 2.0**-9).matrix
    inside = TURN[:, :QUIET].T @ matrix
    assert np.linalg.norm(inside) > 0.995 * np.linalg.norm(matrix)
    moved = np.array([rows[-1] for rows in changes]) @ matrix
    sizes = np.median(np.abs(moved), axis=0)
    np.testing.assert_allclose(sizes / sizes[0], 1.0, atol=0.25)  # all bins as wide, against the drift


def test_other_models_share_a_label_as_often_as_wanted():
    others, _ = planted(5)
    matrix = fit_label_map(*planted(0), QUIET, 2.0**-6).matrix
    found = collision(others @ matrix, np.random.default_rng(0))
    assert 0.8 * 2.0**-6 < found < 1.25 * 2.0**-6


def test_collisions_are_counted():
    rng = np.random.default_rng(0)
    assert collision(np.zeros((5, 2)), rng) == 1.0
    assert collision(10.0 * np.arange(5.0)[:, None], rng) == 0.0
    # Half a bin apart: an edge lies between in half of the cases.
    assert collision(np.array([[0.0], [0.5]]), rng, 4000) == pytest.approx(0.5, abs=0.03)


def test_too_little_to_fit_is_refused():
    models, changes = planted(0)
    for few in ((models[:16], changes, 3), (models, changes[:16], 3), (models, changes, 17)):
        with pytest.raises(InputError, match="expected more than 16"):
            fit_label_map(*few)


def test_drifts_are_changes_of_the_invariants_restoration_by_restoration():
    points, faces = pebble(40)
    mesh = Mesh(points, faces)
    found = {(drift.attack, drift.strength): drift for drift in drifts(mesh, np.random.default_rng(0))}
    assert set(found) >= {kind for kind in ATTACKED if kind[0] != "remeshing"}
    assert {drift.change.shape[1] for drift in some(found.values())} == {COUNT}
    assert np.abs(found["midpoint", 1.0].change[0]).max() < 0.01
    plain, *restored = np.abs(found["smoothing", 30.0].change).max(axis=1)
    assert min(restored) < 0.5 * plain
    noisy = found["noise", 0.005].change[0] + shape_invariants(points, faces)
    assert noisy[3] > shape_invariants(points, faces)[3]  # noise adds area


def test_the_change_of_a_frame_is_that_of_its_best_restoration():
    change = np.zeros((2, COUNT))
    change[0, :3] = [0.0, 0.5, 0.0]
    change[1, :3] = [0.2, 0.1, 0.1]
    assert Drift(attack="noise", strength=0.01, change=change).frame_change == pytest.approx(0.1)

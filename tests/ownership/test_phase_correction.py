"""Errors that many cells share are taken off the phases, whatever the bits."""

from __future__ import annotations

import numpy as np

from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.relief import Relief
from meshmark.ownership.phase_correction import best_correction, corrected_phase, shifts
from tests.counting import some

STEP = 0.12


def patches(count: int = 220, seed: int = 0) -> tuple[Cells, Relief]:
    """Cells around a sphere of radius 5 spacings, with answers to bending of very different sizes."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    nodes = np.round(5.0 * normal).astype(np.int64)
    offset = rng.uniform(-0.4, 0.4, count)
    bending = rng.normal(size=(count, 2)) * 0.02
    grain = np.exp(rng.normal(size=count)) * 0.01
    mass, flatness = rng.uniform(0.4, 1.0, count), rng.uniform(0.7, 1.0, count)
    return Cells(nodes=nodes, offset=offset, normal=normal, mass=mass, flatness=flatness), Relief(
        bending, grain
    )


def test_a_planted_error_is_taken_off():
    rng = np.random.default_rng(1)
    cells, relief = patches()
    bits = rng.integers(0, 2, 220)
    shared = relief.bending @ [0.6, -0.3] + shifts(cells) @ (1e-3 * rng.normal(size=7))
    phase = np.pi * bits + 2.0 * np.pi / STEP * shared + 0.3 * rng.normal(size=220)
    after = corrected_phase(phase, cells, STEP, relief)
    wrong = [float(np.mean((np.cos(values) < 0.0) != (bits == 1))) for values in (phase, after)]
    assert wrong[0] > 0.03
    assert wrong[1] < 0.3 * wrong[0]
    assert np.cos(2.0 * after).mean() > 0.75


def test_the_bits_change_nothing_but_turns_by_pi():
    rng = np.random.default_rng(2)
    cells, relief = patches()
    phase = rng.uniform(-np.pi, np.pi, 220)
    turns = np.pi * rng.integers(-3, 4, 220)
    one = corrected_phase(phase, cells, STEP, relief)
    other = corrected_phase(phase + turns, cells, STEP, relief)
    np.testing.assert_allclose(other, one + turns, atol=1e-9)


def test_exact_phases_stay():
    cells, relief = patches()
    phase = np.pi * np.random.default_rng(3).integers(0, 2, 220).astype(float)
    np.testing.assert_allclose(corrected_phase(phase, cells, STEP, relief), phase, atol=1e-9)


def test_the_correction_is_a_maximum():
    rng = np.random.default_rng(4)
    response, expected = rng.normal(size=(150, 4)), np.full(4, 0.8)
    psi = 0.4 * rng.normal(size=150) - response @ [0.3, -0.2, 0.1, 0.4]

    def value(y):
        return np.cos(psi + response @ y).sum() - 0.5 * np.sum((y / expected) ** 2)

    best = best_correction(psi, response, expected)
    for change in some((*np.eye(4), *-np.eye(4))):
        assert value(best) >= value(best + 1e-3 * change)
    np.testing.assert_allclose(best, [0.3, -0.2, 0.1, 0.4], atol=0.1)


def test_no_cells_give_no_phases():
    cells, relief = patches()
    none = np.zeros(0, dtype=np.int64)
    assert corrected_phase(np.zeros(0), cells.take(none), STEP, relief.take(none)).shape == (0,)

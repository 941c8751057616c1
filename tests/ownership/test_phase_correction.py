"""Errors that many cells share are taken off the phases, whatever the bits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.ownership.phase_correction import best_correction, corrected_phase, shifts
from tests.counting import some
from tests.ownership.observations import STEP, drawn_bits, picked, reading, turned


@pytest.mark.parametrize("pilots", [0.0, 0.2])
def test_a_planted_error_is_taken_off(pilots):
    rng = np.random.default_rng(1)
    seen = reading(pilots=pilots)
    bits = drawn_bits(seen, rng)
    shared = seen.relief.bending @ [0.6, -0.3] + shifts(seen.cells) @ (1e-3 * rng.normal(size=7))
    phase = np.pi * bits + 2.0 * np.pi / STEP * shared + 0.3 * rng.normal(size=220)
    after = corrected_phase(replace(seen, phase=phase))
    wrong = [float(np.mean((np.cos(values) < 0.0) != (bits == 1))) for values in (phase, after)]
    assert wrong[0] > 0.03
    assert wrong[1] < 0.3 * wrong[0]
    assert np.cos(2.0 * after).mean() > 0.75


def test_the_bits_change_nothing_but_turns_by_pi():
    rng = np.random.default_rng(2)
    seen = replace(reading(), phase=rng.uniform(-np.pi, np.pi, 220))
    turns = rng.integers(-3, 4, 220)
    one = corrected_phase(seen)
    other = corrected_phase(replace(seen, phase=turned(seen, turns)))
    np.testing.assert_allclose(other, one + turned(seen, turns) - seen.phase, atol=1e-9)


def test_exact_phases_stay():
    seen = reading()
    phase = np.pi * drawn_bits(seen, np.random.default_rng(3)).astype(float)
    np.testing.assert_allclose(corrected_phase(replace(seen, phase=phase)), phase, atol=1e-9)


def test_pilots_tell_an_error_that_doubled_phases_do_not():
    """Off by half a turn, doubled phases are as good as before; single ones are not."""
    rng = np.random.default_rng(5)
    seen = reading(pilots=0.4)
    typical = 1.5 * np.median(np.abs(seen.relief.bending[:, 0]))
    off = np.clip(seen.relief.bending[:, 0] / typical, -4.0, 4.0)
    phase = 1.2 * off + 0.2 * rng.normal(size=220)
    after = corrected_phase(replace(seen, phase=phase))
    assert np.cos(phase[seen.keys.pilot]).mean() < 0.7
    assert np.cos(after[seen.keys.pilot]).mean() > 0.9


def test_the_correction_is_a_maximum():
    rng = np.random.default_rng(4)
    response, expected = rng.normal(size=(150, 4)), np.full(4, 0.8)
    weight = rng.uniform(0.3, 1.8, 150)
    psi = 0.4 * rng.normal(size=150) - response @ [0.3, -0.2, 0.1, 0.4]

    def value(y):
        return weight @ np.cos(psi + response @ y) - 0.5 * np.sum((y / expected) ** 2)

    best = best_correction(psi, response, expected, weight)
    for change in some((*np.eye(4), *-np.eye(4))):
        assert value(best) >= value(best + 1e-3 * change)
    np.testing.assert_allclose(best, [0.3, -0.2, 0.1, 0.4], atol=0.1)


def test_no_cells_give_no_phases():
    assert corrected_phase(picked(reading(), np.zeros(0, dtype=np.int64))).shape == (0,)

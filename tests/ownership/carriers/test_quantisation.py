from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.quantisation import (
    bit_phase,
    lock_score,
    log10_lock_chance,
    log_likelihood_ratio,
    log_likelihood_ratio_of_points,
    nearest_offsets,
)

RANDOM = np.random.default_rng(5)


def some_cells(count):
    return RANDOM.normal(size=count), RANDOM.random(count), RANDOM.integers(2, size=count)


def test_shifted_offsets_say_their_bits_with_full_lock():
    offsets, dither, bits = some_cells(200)
    shifted = offsets + nearest_offsets(offsets, dither, bits, 0.1, np.eye(200))
    phase = bit_phase(shifted, dither, 0.1)
    np.testing.assert_array_equal(np.cos(phase) < 0, bits == 1)
    assert float(lock_score(2.0 * phase, np.ones(200))) == pytest.approx(200.0)


def test_without_coupling_every_shift_is_the_nearest():
    offsets, dither, bits = some_cells(200)
    assert np.abs(nearest_offsets(offsets, dither, bits, 0.1, np.eye(200))).max() <= 0.05 + 1e-12


def test_coupled_shifts_cost_no_more_than_rounding_and_often_the_least():
    best = 0
    for _ in range(20):
        offsets, dither, bits = some_cells(4)
        root = RANDOM.normal(size=(4, 4))
        cost = root @ root.T + 0.05 * np.eye(4)
        change = nearest_offsets(offsets, dither, bits, 0.1, cost)
        plain = nearest_offsets(offsets, dither, bits, 0.1, np.diag(np.diag(cost)))
        energies = [
            (plain + 0.1 * np.array(turn)) @ cost @ (plain + 0.1 * np.array(turn))
            for turn in product(range(-3, 4), repeat=4)
        ]
        assert change @ cost @ change <= plain @ cost @ plain + 1e-12
        best += change @ cost @ change <= min(energies) + 1e-12
    assert best >= 12


@pytest.mark.parametrize("pilots", [0, 12, 60])
def test_lock_bound_holds_for_uniform_phases(pilots):
    """Bits turn doubled phases by 2 pi; those of pilots, which count more, are single and their bits known."""
    count, trials = 60, 4000
    keys = CellKeys(code_index=np.arange(count), dither=np.zeros(count), pilot=np.arange(count) < pilots)
    assert np.mean(keys.weight**2) == pytest.approx(1.0)
    scores = lock_score(keys.factor * RANDOM.uniform(0, 2 * np.pi, size=(trials, count)), keys.weight)
    for quantile in (0.9, 0.99, 0.999):
        score = float(np.quantile(scores, quantile))
        assert 10 ** log10_lock_chance(score, count) >= 1 - quantile


def test_likelihood_is_antisymmetric_and_right_on_clean_and_noisy_phases():
    phase = RANDOM.normal(0, 0.3, 500) + np.pi * RANDOM.integers(2, size=500)
    ratio = log_likelihood_ratio(phase)
    np.testing.assert_allclose(log_likelihood_ratio(phase + np.pi), -ratio, atol=1e-9)
    np.testing.assert_array_equal(ratio > 0, np.cos(phase) > 0)
    noisy = log_likelihood_ratio(RANDOM.uniform(0, 2 * np.pi, 500))
    assert np.abs(noisy).mean() < 0.3 * np.abs(ratio).mean()


def of_points(broken: float, off: float, count: int = 600):
    """Phases of random bits, some of them broken, and the bits."""
    random = np.random.default_rng(3)
    bits = random.integers(0, 2, count)
    phase = np.pi * bits + off * random.normal(size=count)
    gone = random.random(count) < broken
    phase[gone] = random.uniform(-np.pi, np.pi, int(gone.sum()))
    return phase, bits


@pytest.mark.parametrize("broken", [0.0, 0.2, 0.5])
def test_points_that_could_not_be_set_hardly_count(broken):
    phase, bits = of_points(broken, 0.05)
    told = log_likelihood_ratio_of_points(phase) * (1 - 2 * bits)
    assert (told > 0.0).mean() >= 1.0 - broken
    assert -told[told < 0.0].sum() < 0.1 * told[told > 0.0].sum()
    assert told.mean() > 0.7 * (1.0 - broken) * told.max()


def test_what_points_tell_is_turned_round_with_their_bits():
    phase, _ = of_points(0.3, 0.3)
    assert np.allclose(log_likelihood_ratio_of_points(phase), -log_likelihood_ratio_of_points(phase + np.pi))
    assert log_likelihood_ratio_of_points(phase[:0]).shape == (0,)


def test_without_a_mark_points_tell_little():
    phase = np.random.default_rng(5).uniform(-np.pi, np.pi, 500)
    marked, _ = of_points(0.0, 0.05)
    assert np.abs(log_likelihood_ratio_of_points(phase)).mean() < 1.0
    assert np.abs(log_likelihood_ratio_of_points(marked)).mean() > 4.0

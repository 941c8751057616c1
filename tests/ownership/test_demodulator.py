"""The demodulator: fair signs without a mark whatever its weights, and better soft values than a cosine."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.network.perceptron import Perceptron, count_weights
from meshmark.ownership.carrier_features import FEATURES, carrier_features
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio
from meshmark.ownership.demodulator import demodulate
from meshmark.research.training.demodulator_training import information
from tests.ownership.test_phase_correction import STEP, patches


def wild_network(seed: int) -> Perceptron:
    """Weights that nothing was trained to."""
    sizes = (len(FEATURES), 6, 3, 1)
    rng = np.random.default_rng(seed)
    weights = rng.normal(size=count_weights(sizes))
    return Perceptron(
        sizes=sizes, centre=rng.normal(size=len(FEATURES)), scale=np.ones(len(FEATURES)), weights=weights
    )


@given(seed=st.integers(0, 10_000), cell=st.integers(0, 89))
@settings(max_examples=30, deadline=None)
def test_turning_one_phase_by_pi_turns_its_ratio_and_no_other(seed, cell):
    rng = np.random.default_rng(seed)
    cells, relief = patches(90, seed)
    phase = rng.uniform(-np.pi, np.pi, 90)
    turned = phase.copy()
    turned[cell] += np.pi
    network = wild_network(seed)
    one, other = (demodulate(values, cells, STEP, relief, network) for values in (phase, turned))
    flips = np.ones(90)
    flips[cell] = -1.0
    np.testing.assert_allclose(other, one * flips, rtol=1e-6, atol=1e-9)


def test_without_a_mark_the_signs_are_fair_coins_even_for_a_given_word():
    # Magnitudes may be anything; their signs must not agree with any word better than chance.
    rng = np.random.default_rng(5)
    cells, relief = patches(200)
    word = rng.choice([-1.0, 1.0], 200)
    network = wild_network(3)
    agreements = []
    for _ in range(300):
        ratio = demodulate(rng.uniform(-np.pi, np.pi, 200), cells, STEP, relief, network)
        agreements.append(float(word @ ratio / np.sqrt(ratio @ ratio)))
    assert abs(np.mean(agreements)) < 4.0 / np.sqrt(300)
    assert 0.8 < np.std(agreements) < 1.2


def test_features_know_nothing_of_bits_and_have_their_names():
    rng = np.random.default_rng(6)
    cells, relief = patches(120)
    phase = rng.uniform(-np.pi, np.pi, 120)
    one = carrier_features(phase, cells, STEP, relief)
    assert one.shape == (120, len(FEATURES))
    assert np.isfinite(one).all()
    turned = phase + np.pi * rng.integers(0, 2, 120)
    np.testing.assert_allclose(carrier_features(turned, cells, STEP, relief), one, atol=1e-9)
    np.testing.assert_allclose(one[:, 0], np.cos(2.0 * phase), atol=1e-12)


def test_features_do_not_depend_on_the_order_of_cells():
    rng = np.random.default_rng(7)
    cells, relief = patches(80)
    phase = rng.uniform(-np.pi, np.pi, 80)
    order = rng.permutation(80)
    shuffled = carrier_features(phase[order], cells.take(order), STEP, relief.take(order))
    np.testing.assert_allclose(shuffled, carrier_features(phase, cells, STEP, relief)[order], atol=1e-9)


@pytest.mark.parametrize("noise", [0.5, 0.9])
def test_the_shipped_network_tells_more_than_the_plain_rules(noise):
    rng = np.random.default_rng(8)
    found = {"cosine": [], "rule": [], "network": []}
    targets = []
    for seed in range(40):
        cells, relief = patches(220, seed)
        bits = rng.integers(0, 2, 220)
        # Noise in proportion to what each patch's roughness foretells, and an error in common.
        spread = noise * (0.5 + relief.grain / relief.grain.mean())
        shared = 2.0 * np.pi / STEP * relief.bending @ rng.normal(size=2) * 0.6
        phase = np.pi * bits + shared + spread * rng.normal(size=220)
        found["cosine"].append(np.cos(phase))
        found["rule"].append(log_likelihood_ratio(phase))
        found["network"].append(demodulate(phase, cells, STEP, relief))
        targets.append(1.0 - 2.0 * bits)
    told = {name: information(np.concatenate(soft), np.concatenate(targets)) for name, soft in found.items()}
    assert told["network"] > 1.1 * max(told["cosine"], told["rule"])


def test_no_cells_give_no_ratios():
    cells, relief = patches(10)
    none = np.zeros(0, dtype=np.int64)
    assert demodulate(np.zeros(0), cells.take(none), STEP, relief.take(none)).shape == (0,)

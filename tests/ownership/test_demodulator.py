"""The demodulator: fair signs without a mark whatever its weights, and better soft values than a cosine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.network.perceptron import Perceptron, count_weights
from meshmark.ownership.carrier_features import FEATURES, carrier_features
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio
from meshmark.ownership.demodulator import demodulate
from meshmark.research.training.demodulator_training import information
from tests.ownership.observations import STEP, drawn_bits, picked, reading, turned


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
    seen = replace(reading(90, seed), phase=rng.uniform(-np.pi, np.pi, 90))
    network = wild_network(seed)
    one, other = (
        demodulate(replace(seen, phase=turned(seen, turns)), network)
        for turns in (np.zeros(90), np.arange(90) == cell)
    )
    flips = np.ones(90)
    flips[cell] = -1.0
    np.testing.assert_allclose(other, one * flips, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(one == 0.0, seen.keys.pilot)


def test_without_a_mark_the_signs_are_fair_coins_even_for_a_given_word():
    # Magnitudes may be anything; their signs must not agree with any word better than chance.
    rng = np.random.default_rng(5)
    seen = reading(200)
    word = rng.choice([-1.0, 1.0], 200)
    network = wild_network(3)
    agreements = []
    for _ in range(300):
        ratio = demodulate(replace(seen, phase=rng.uniform(-np.pi, np.pi, 200)), network)
        agreements.append(float(word @ ratio / np.sqrt(ratio @ ratio)))
    assert abs(np.mean(agreements)) < 4.0 / np.sqrt(300)
    assert 0.8 < np.std(agreements) < 1.2


@pytest.mark.parametrize("pilots", [0.0, 0.2, 1.0])
def test_features_know_nothing_of_bits_and_have_their_names(pilots):
    rng = np.random.default_rng(6)
    seen = replace(reading(120, pilots=pilots), phase=rng.uniform(-np.pi, np.pi, 120))
    one = carrier_features(seen)
    assert one.shape == (120, len(FEATURES))
    assert np.isfinite(one).all()
    other = replace(seen, phase=turned(seen, rng.integers(0, 2, 120)))
    np.testing.assert_allclose(carrier_features(other), one, atol=1e-9)
    np.testing.assert_allclose(one[:, 0], np.cos(2.0 * seen.phase), atol=1e-12)


def test_the_lock_of_pilots_is_seen_where_compensation_leaves_none_of_the_others():
    seen = reading(200)
    gone = np.where(seen.keys.pilot, 0.6, np.where(np.arange(200) % 2, 0.7, 0.9))
    found = carrier_features(replace(seen, phase=gone))
    lock, pilots = (np.exp(found[0, FEATURES.index(name)]) for name in ("log lock", "log pilot lock"))
    assert lock == pytest.approx(0.02)
    assert pilots == pytest.approx(np.cos(0.6))


def test_features_do_not_depend_on_the_order_of_cells():
    rng = np.random.default_rng(7)
    seen = replace(reading(80), phase=rng.uniform(-np.pi, np.pi, 80))
    order = rng.permutation(80)
    np.testing.assert_allclose(
        carrier_features(picked(seen, order)), carrier_features(seen)[order], atol=1e-9
    )


@pytest.mark.parametrize("noise", [0.5, 0.9])
def test_the_shipped_network_tells_more_than_the_plain_rules(noise):
    rng = np.random.default_rng(8)
    found = {"cosine": [], "rule": [], "network": []}
    targets = []
    for seed in range(40):
        seen = reading(220, seed)
        bits, relief = drawn_bits(seen, rng), seen.relief
        told = ~seen.keys.pilot
        # Noise in proportion to what each patch's roughness foretells, and an error in common.
        spread = noise * (0.5 + relief.grain / relief.grain.mean())
        shared = 2.0 * np.pi / STEP * relief.bending @ rng.normal(size=2) * 0.6
        phase = np.pi * bits + shared + spread * rng.normal(size=220)
        found["cosine"].append(np.cos(phase)[told])
        found["rule"].append(log_likelihood_ratio(phase)[told])
        found["network"].append(demodulate(replace(seen, phase=phase))[told])
        targets.append(1.0 - 2.0 * bits[told])
    bits = {name: information(np.concatenate(soft), np.concatenate(targets)) for name, soft in found.items()}
    assert bits["network"] > 1.1 * max(bits["cosine"], bits["rule"])


def test_no_cells_give_no_ratios():
    assert demodulate(picked(reading(10), np.zeros(0, dtype=np.int64))).shape == (0,)


def test_pilots_alone_give_no_ratios():
    seen = reading(30, pilots=1.0)
    np.testing.assert_array_equal(demodulate(seen), np.zeros(30))

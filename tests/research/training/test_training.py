"""Training: what it learns from is true, it repeats, and what it judges by is what the words say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.coding.codec import CHECK_WORD_LIMIT
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.ownership.demodulator import demodulate
from meshmark.research.training.demodulator_training import (
    figures,
    information,
    raw_errors,
    train_demodulator,
)
from meshmark.research.training.demodulator_trials import Trial, mark, trials
from tests.counting import some
from tests.ownership.observations import drawn_bits, reading
from tests.shapes import pebble

TETRAHEDRON = Mesh(
    np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.5]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)


def made_up(seed: int, noise: float = 0.7) -> Trial:
    rng = np.random.default_rng(seed)
    seen = reading(200, seed)
    bits = drawn_bits(seen, rng)
    spread = noise * seen.relief.grain / seen.relief.grain.mean()
    phase = np.pi * bits + spread * rng.normal(size=200)
    return Trial(
        attack="noise",
        strength=noise,
        seen=replace(seen, phase=phase),
        targets=np.where(seen.keys.pilot, 0.0, 1.0 - 2.0 * bits),
    )


def test_trials_are_readings_of_the_marked_bits():
    rng = np.random.default_rng(0)
    marked = mark(Mesh(*pebble(120)), rng)
    assert marked is not None
    found = list(trials(marked, rng, (("float32", 1.0), ("noise", 0.005))))
    assert {trial.attack for trial in found} == {"float32", "noise"}
    for trial in some(found):
        told = ~trial.seen.keys.pilot
        assert (trial.targets[told] == 1.0 - 2.0 * marked.bits[trial.seen.keys.code_index[told]]).all()
        assert (trial.targets[~told] == 0.0).all()
        assert 0.1 < np.mean(~told) < 0.3
    clean, noised = (next(trial for trial in found if trial.attack == name) for name in ("float32", "noise"))
    # What is compensated says some bits wrong even where nothing was done to it.
    errors = [raw_errors(np.cos(trial.seen.phase), trial.targets) for trial in (clean, noised)]
    assert errors[0] < 0.2
    assert errors[0] < errors[1] < 0.36
    observed = np.bincount(clean.seen.keys.code_index, demodulate(clean.seen), marked.codec.n)
    decoded = marked.codec.decode(observed)
    assert decoded.id == marked.identity
    assert decoded.log10_chance < CHECK_WORD_LIMIT


def test_a_model_without_room_is_no_trial():
    assert mark(TETRAHEDRON, np.random.default_rng(0)) is None


def test_training_repeats_and_learns_what_grain_tells():
    models = {f"model {i}": [made_up(10 * i + j) for j in range(4)] for i in range(6)}
    first, second = (train_demodulator(models, 3) for _ in range(2))
    assert (first.network.weights == second.network.weights).all()
    assert first.notes == second.notes
    assert first.notes["models for validation"] == ["model 0", "model 3"]
    fresh = figures([made_up(1000 + i) for i in range(30)], first.network)["all"]
    assert fresh["bits network"] > 1.1 * max(fresh["bits cosine"], fresh["bits wrapped normal"])


def test_training_needs_two_models():
    with pytest.raises(InputError, match="1 models could be marked and read, expected at least 2"):
        train_demodulator({"one": [made_up(0)], "none": []}, 0)


def test_information_is_that_of_known_channels():
    rng = np.random.default_rng(1)
    targets = rng.choice([-1.0, 1.0], 50_000)
    # A binary symmetric channel with 11 % errors carries 1 - h(0.11) bits, at any scale of its values.
    flips = np.where(rng.uniform(size=50_000) < 0.11, -1.0, 1.0)
    expected = 1.0 + 0.11 * np.log2(0.11) + 0.89 * np.log2(0.89)
    for scale in (0.1, 1.0, 7.0):
        assert information(scale * targets * flips, targets) == pytest.approx(expected, abs=0.012)
    # An erased half says nothing, the other half all.
    assert information(10.0 * targets * (rng.uniform(size=50_000) < 0.5), targets) == pytest.approx(
        0.5, abs=0.01
    )
    assert raw_errors(targets * flips, targets) == pytest.approx(0.11, abs=0.006)


def test_pilots_count_neither_as_errors_nor_as_information():
    targets = np.array([1.0, -1.0, 1.0, -1.0, 0.0, 0.0, 0.0])
    soft = np.array([2.0, -3.0, 1.0, 0.5, -9.0, 9.0, 0.0])
    assert raw_errors(soft, targets) == 0.25
    assert information(soft, targets) == information(soft[:4], targets[:4])

"""The network's values against a formula written out, and its Jacobian against differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.network.perceptron import Perceptron, count_weights
from tests.counting import some


def random_network(seed: int, hidden: tuple[int, ...], inputs: int = 3) -> tuple[Perceptron, np.ndarray]:
    rng = np.random.default_rng(seed)
    data = rng.normal(size=(12, inputs)) * 3.0 + 5.0
    network = Perceptron.drawn(data, hidden, rng)
    return network.with_weights(rng.normal(size=len(network.weights))), data


def test_values_are_the_formula():
    network = Perceptron(
        sizes=(2, 2, 1),
        centre=np.array([1.0, -1.0]),
        scale=np.array([2.0, 4.0]),
        weights=np.array([1.0, 2.0, 3.0, 4.0, 0.1, 0.2, 5.0, 6.0, 0.3]),
    )
    a, b = (3.0 - 1.0) / 2.0, (7.0 + 1.0) / 4.0
    expected = 5.0 * np.tanh(a + 2 * b + 0.1) + 6.0 * np.tanh(3 * a + 4 * b + 0.2) + 0.3
    assert network(np.array([[3.0, 7.0]])) == pytest.approx([expected], rel=1e-15)


@given(seed=st.integers(0, 10_000), hidden=st.sampled_from([(), (4,), (5, 3), (4, 3, 2)]))
@settings(max_examples=25, deadline=None)
def test_jacobian_is_that_of_central_differences(seed, hidden):
    network, data = random_network(seed, hidden)
    values, jacobian = network.jacobian(data)
    assert (values == network(data)).all()
    step = 1e-6
    for column, change in some(enumerate(np.eye(len(network.weights)) * step)):
        ahead = network.with_weights(network.weights + change)(data)
        behind = network.with_weights(network.weights - change)(data)
        difference = (ahead - behind) / (2.0 * step)
        np.testing.assert_allclose(jacobian[:, column], difference, rtol=1e-6, atol=1e-7)


def test_a_drawn_network_starts_at_zero_and_repeats_with_its_seed():
    data = np.random.default_rng(1).normal(size=(50, 4))
    data[:, 2] = 7.0  # an input that never changes
    first, second = (Perceptron.drawn(data, (6, 3), np.random.default_rng(5)) for _ in range(2))
    assert (first.weights == second.weights).all()
    assert (first(data) == 0.0).all()
    assert first.scale[2] == 1.0
    assert len(first.weights) == count_weights((4, 6, 3, 1)) == 5 * 6 + 7 * 3 + 4


def test_no_rows_give_no_values():
    network, _ = random_network(0, (4,))
    values, jacobian = network.jacobian(np.zeros((0, 3)))
    assert values.shape == (0,)
    assert jacobian.shape == (0, len(network.weights))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"sizes": (2,)}, "expected two or more"),
        ({"sizes": (2, 3)}, "the last of one unit"),
        ({"weights": np.zeros(8)}, "expected"),
        ({"weights": np.full(9, np.nan)}, "not finite"),
        ({"scale": np.array([1.0, 0.0])}, "not positive"),
    ],
)
def test_what_cannot_be_a_network_is_refused(change, words):
    fields = {"sizes": (2, 2, 1), "centre": np.zeros(2), "scale": np.ones(2), "weights": np.zeros(9)}
    with pytest.raises(InputError, match=words):
        Perceptron(**(fields | change))

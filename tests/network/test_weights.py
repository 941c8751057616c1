"""Networks written and read again."""

from __future__ import annotations

import json

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.network.perceptron import Perceptron
from meshmark.network.weights import dump_network, parse_network

FEATURES = ("mass", "flatness")


@pytest.fixture
def network() -> Perceptron:
    rng = np.random.default_rng(3)
    drawn = Perceptron.drawn(rng.normal(size=(20, 2)), (4, 3), rng)
    return drawn.with_weights(rng.normal(size=len(drawn.weights)) * 10.0 ** rng.integers(-9, 9))


def test_a_network_comes_back_to_the_last_bit(network):
    text = dump_network(network, FEATURES, {"command": "meshmark train", "seed": 7})
    again = parse_network(text, FEATURES)
    assert again.sizes == network.sizes
    for name in ("centre", "scale", "weights"):
        assert (getattr(again, name) == getattr(network, name)).all()
    assert json.loads(text)["seed"] == 7


def test_other_features_and_other_texts_are_refused(network):
    text = dump_network(network, FEATURES, {})
    with pytest.raises(InputError, match="takes mass, flatness, expected flatness, mass"):
        parse_network(text, FEATURES[::-1])
    with pytest.raises(InputError, match="of kind 'other'"):
        parse_network(text.replace("meshmark network 1", "other"), FEATURES)
    for broken in ("", "[]", "{}", text[:-40], text.replace('"weights"', '"wait"')):
        with pytest.raises(InputError, match="not a network file"):
            parse_network(broken, FEATURES)
    with pytest.raises(InputError, match="1 features are named, expected 2"):
        dump_network(network, FEATURES[:1], {})

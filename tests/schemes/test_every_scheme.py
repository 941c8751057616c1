"""What every scheme must do, whatever it is."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.schemes import SCHEMES
from tests.shapes import pebble

KEY = Key(b"k" * 32)


@pytest.fixture(scope="module", params=list(SCHEMES))
def scheme(request):
    return SCHEMES[request.param]


@pytest.fixture(scope="module")
def host():
    return Mesh(*pebble())


def payload(scheme, seed=0):
    return np.random.default_rng(seed).integers(0, 2, scheme.bits).astype(np.uint8)


@pytest.fixture(scope="module")
def marked(scheme, host):
    return scheme.embed(host, payload(scheme), KEY)


def read(scheme, mesh, host, key=KEY):
    return scheme.extract(mesh, key, reference=None if scheme.blind else host)


def test_the_payload_comes_back(scheme, marked, host):
    found = read(scheme, marked, host)
    assert found.present
    assert np.array_equal(found.bits, payload(scheme))


def test_what_was_seen_of_the_code_is_the_code(scheme, marked, host):
    found = read(scheme, marked, host)
    if found.raw is None:
        pytest.skip("a scheme without error correction")
    seen = found.raw != 0
    assert seen.sum() >= scheme.bits
    code = scheme.code(payload(scheme), KEY)
    assert np.mean((found.raw[seen] < 0) != code[seen]) < 0.05


def test_only_positions_change_and_little(scheme, marked, host):
    assert np.array_equal(marked.faces, host.faces)
    moved = np.linalg.norm(marked.vertices - host.vertices, axis=1)
    assert 0 < np.sqrt((moved**2).mean()) <= 8e-4 * np.linalg.norm(np.ptp(host.vertices, axis=0))


def test_the_same_input_gives_the_same_output(scheme, marked, host):
    again = scheme.embed(host, payload(scheme), KEY)
    assert np.array_equal(again.vertices, marked.vertices)


def test_wrong_keys_and_unmarked_models_read_chance(scheme, marked, host):
    wrong = [read(scheme, marked, host, Key(bytes([i]) * 32)) for i in range(4)]
    none = [read(scheme, host, host, Key(bytes([i]) * 32)) for i in range(4)]
    assert not any(found.present for found in wrong + none)
    errors = np.concatenate([found.bits != payload(scheme) for found in wrong + none])
    # five standard deviations of as many fair coins
    assert abs(errors.mean() - 0.5) < 2.5 / np.sqrt(len(errors))


def test_a_payload_of_another_length_is_refused(scheme, host):
    with pytest.raises(InputError, match="payload"):
        scheme.embed(host, np.zeros(scheme.bits + 1, np.uint8), KEY)

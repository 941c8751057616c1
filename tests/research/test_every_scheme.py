"""What every scheme must do, whatever it is."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.displacement import rms_over_diagonal
from meshmark.research import SCHEMES
from meshmark.strengths import BUDGETS
from tests.counting import some
from tests.shapes import pebble

KEY = Key(b"k" * 32)


@pytest.fixture(scope="module", params=list(SCHEMES))
def scheme(request):
    return SCHEMES[request.param]


@pytest.fixture(scope="module")
def host():
    """A pebble on which no distance from the middle is rare: the schemes that count distances need many of each."""
    points, faces = pebble(90)
    return Mesh(points * [0.6, 0.9, 1.5], faces)


def payload(scheme, seed=0):
    return np.random.default_rng(seed).integers(0, 2, scheme.bits).astype(np.uint8)


@pytest.fixture(scope="module")
def marked(scheme, host):
    return scheme.embed(host, payload(scheme), KEY)


@pytest.fixture(scope="module")
def kept(scheme, marked, host):
    """What the owner has beside the key."""
    if scheme.blind:
        return None
    return scheme.kept(marked, KEY) if hasattr(scheme, "kept") else host


@pytest.fixture(scope="module")
def found(scheme, marked, kept):
    return scheme.extract(marked, KEY, reference=kept)


def test_the_payload_comes_back(scheme, found):
    assert found.present
    assert np.array_equal(found.bits, payload(scheme))


def test_what_was_seen_of_the_code_is_the_code(scheme, found):
    if found.raw is None:
        pytest.skip("a scheme that does not tell what it saw of a code")
    seen = found.raw != 0
    assert seen.sum() >= scheme.bits
    code = scheme.code(payload(scheme), KEY)
    assert np.mean((found.raw[seen] < 0) != code[seen]) < 0.05


def test_a_bound_is_one_and_agrees_with_the_word(found):
    if found.log10_false_positive is None:
        pytest.skip("a scheme without a bound")
    assert found.log10_false_positive <= -3.0


@pytest.mark.parametrize("strength", ["subtle", "standard"])
def test_only_positions_change_and_within_the_budget(scheme, marked, host, strength):
    mesh = marked if strength == "standard" else scheme.embed(host, payload(scheme), KEY, strength=strength)
    assert np.array_equal(mesh.faces, host.faces)
    assert 0 < rms_over_diagonal(host, mesh) <= BUDGETS[strength]


def test_the_same_input_gives_the_same_output(scheme, marked, host):
    again = scheme.embed(host, payload(scheme), KEY)
    assert np.array_equal(again.vertices, marked.vertices)


def test_wrong_keys_and_unmarked_models_read_chance(scheme, marked, host, kept, short_search):
    """Few trials: a wrong key makes a reader try all that it can try, which takes seconds."""
    trials = [(marked, Key(b"0" * 32)), (host, KEY)]
    read = [scheme.extract(mesh, key, reference=kept) for mesh, key in trials]
    assert not any(each.present for each in some(read))
    errors = np.concatenate([each.bits != payload(scheme) for each in some(read)])
    # five standard deviations of as many fair coins
    assert abs(errors.mean() - 0.5) < 2.5 / np.sqrt(len(errors))


def test_a_payload_of_another_length_is_refused(scheme, host):
    with pytest.raises(InputError, match="payload"):
        scheme.embed(host, np.zeros(scheme.bits + 1, np.uint8), KEY)


def test_an_unknown_strength_is_refused(scheme, host):
    with pytest.raises(InputError, match="unknown strength 'nonsense'"):
        scheme.embed(host, payload(scheme), KEY, strength="nonsense")

from __future__ import annotations

import json

import numpy as np
import pytest

from meshmark.attacks import find_attack
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.invariants import INVARIANTS, shape_invariants
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice_label import (
    Label,
    LabelMap,
    dump_map,
    labels,
    parse_map,
    shipped_map,
)
from tests.counting import some
from tests.shapes import pebble

KEY = Key(bytes(range(32)))
# The first three invariants are the coordinates.
PLAIN = LabelMap(np.eye(len(INVARIANTS), 3))


def at(*coordinates: float) -> np.ndarray:
    return np.concatenate([coordinates, np.zeros(len(INVARIANTS) - len(coordinates))])


def edge(index: int) -> float:
    """Return where the first bin edge above 0 of a coordinate is, found by the label alone."""
    low, high = 0.0, 1.0
    unit = np.eye(3)[index]
    first = labels(at(0.0, 0.0, 0.0), KEY, 1, PLAIN)
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if labels(at(*(middle * unit)), KEY, 1, PLAIN) == first else (low, middle)
    return high


def test_labels_are_different_and_a_longer_list_only_adds():
    whole = labels(at(0.3, 0.1, 0.9), KEY, 100, PLAIN)
    assert len(set(whole)) == len(whole) == 8
    for most in range(1, 9):
        assert labels(at(0.3, 0.1, 0.9), KEY, most, PLAIN) == whole[:most]


def test_labels_beyond_the_dearest_price_are_left_out_but_for_the_first():
    middle = np.array([edge(i) - 0.5 for i in range(3)])
    here = at(*(middle + np.array((0.4, -0.3, 0.0))))  # prices: 0, .01, .04, .05, and more
    whole = labels(here, KEY, 8, PLAIN)
    for dearest, count in ((0.0, 1), (0.0099, 1), (0.0101, 2), (0.0401, 3), (0.0501, 4)):
        assert labels(here, KEY, 8, PLAIN, dearest=dearest) == whole[:count]
    assert labels(here, KEY, 2, PLAIN, dearest=0.0501) == whole[:2]


def test_a_bin_is_one_wide_and_every_key_has_edges_of_its_own():
    assert 0 < edge(0) <= 1
    step = edge(0)
    inside = labels(at(step + 1e-3, 0, 0), KEY, 1, PLAIN)
    assert labels(at(step + 1 - 1e-3, 0, 0), KEY, 1, PLAIN) == inside
    assert labels(at(step + 1 + 1e-3, 0, 0), KEY, 1, PLAIN) != inside
    assert len({edge(0), edge(1), edge(2)}) == 3


@pytest.mark.parametrize("index", [0, 1, 2])
def test_across_the_nearest_edge_the_label_comes_second(index):
    unit = np.eye(3)[index]
    middle = np.array([edge(i) - 0.5 for i in range(3)])  # of a bin, in each coordinate
    before = middle + (0.5 - 0.01) * unit
    after = middle + (0.5 + 0.02) * unit
    true, other = (labels(at(*place), KEY, 2, PLAIN) for place in (before, after))
    assert true[0] != other[0]
    assert other[1] == true[0]
    assert true[1] == other[0]


def test_the_nearer_of_two_edges_comes_first_and_both_of_them_after():
    middle = np.array([edge(i) - 0.5 for i in range(3)])
    here, first, second, both = (
        middle + np.array(step)
        for step in ((0.45, -0.4, 0), (0.55, -0.4, 0), (0.45, -0.6, 0), (0.55, -0.6, 0))
    )
    found = labels(at(*here), KEY, 4, PLAIN)
    assert found[1:] == tuple(labels(at(*place), KEY, 1, PLAIN)[0] for place in (first, second, both))


def test_last_bits_of_the_invariants_do_not_matter():
    rng = np.random.default_rng(0)
    for _ in some(range(200), least=200):
        values = rng.normal(size=len(INVARIANTS))
        other = values + 1e-13 * rng.normal(size=len(INVARIANTS))
        assert labels(values, KEY) == labels(other, KEY)


def test_labels_belong_to_the_key():
    values = at(0.3, 0.1, 0.9)
    assert not set(labels(values, KEY, 8, PLAIN)) & set(labels(values, Key(bytes(32)), 8, PLAIN))


@pytest.mark.parametrize(
    ("attack", "strength"),
    [
        ("noise", 0.001),
        ("quantisation", 10),
        ("simplification", 0.5),
        ("midpoint", 1),
        ("similarity", 1),
        ("mirror", 1),
        ("shuffle", 1),
    ],
)
def test_a_damaged_model_still_has_its_label(attack, strength):
    mesh = Mesh(*pebble())
    damaged = find_attack(attack)(mesh, strength, np.random.default_rng(0))
    for number in some(range(5), least=5):
        key = Key(bytes([number]) * 32)
        true = labels(shape_invariants(mesh.vertices, mesh.faces), key, 1)[0]
        assert true in labels(shape_invariants(damaged.vertices, damaged.faces), key)


def test_other_proportions_have_another_label():
    points, faces = pebble()
    one, other = (shape_invariants(points * size, faces) for size in ([1.0, 1.0, 1.0], [1.0, 1.0, 1.6]))
    assert not set(labels(one, KEY)) & set(labels(other, KEY))


def test_maps_come_back_from_their_text_to_the_last_bit():
    drawn = LabelMap(np.random.default_rng(0).normal(size=(len(INVARIANTS), 4)))
    np.testing.assert_array_equal(parse_map(dump_map(drawn, {"note": "drawn"})).matrix, drawn.matrix)


def test_the_shipped_map_keeps_its_invariants_and_says_how_it_was_made():
    assert shipped_map().components == 6


def test_what_is_no_map_is_refused():
    text = dump_map(PLAIN, {})
    fields = json.loads(text)
    for wrong, reason in (
        ("{", "not a label map"),
        (text.replace("label map 1", "label map 9"), "of kind"),
        (json.dumps({**fields, "matrix": {"area": [1.0]}}), "takes area"),
        (json.dumps({**fields, "matrix": 3}), "not a label map"),
    ):
        with pytest.raises(InputError, match=reason):
            parse_map(wrong)
    with pytest.raises(InputError, match="row for each"):
        LabelMap(np.zeros((2, 3)))


def test_wrong_arguments_are_refused():
    with pytest.raises(InputError, match="at least 1"):
        labels(at(0, 0, 0), KEY, 0, PLAIN)
    with pytest.raises(InputError, match="finite"):
        labels(at(np.nan, 0, 0), KEY, 1, PLAIN)
    with pytest.raises(InputError, match="finite"):
        labels(np.zeros(3), KEY, 1, PLAIN)
    with pytest.raises(InputError, match="16"):
        Label(b"short")

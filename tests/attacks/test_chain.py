"""Chains: their text, their random streams, and the maps of all steps combined."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.attacks import ATTACKS, Attack, Attacked, Chain, Given, parse_chain, table
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.models import given_for, seamed
from tests.counting import some
from tests.shapes import pebble

MODEL = seamed()

steps = st.one_of(
    st.tuples(st.sampled_from(["noise", "gaussian"]), st.floats(0, 1e22)),
    st.tuples(st.sampled_from(["crop", "simplification"]), st.floats(0, 1)),
    st.tuples(st.sampled_from(["smoothing", "taubin"]), st.integers(0, 100).map(float)),
    st.tuples(st.sampled_from(["similarity", "mirror", "shuffle", "file_3mf"]), st.sampled_from([0.0, 1.0])),
)


@given(st.lists(steps, max_size=6).map(tuple))
def test_the_text_says_everything(listed):
    chain = Chain(listed)
    assert parse_chain(str(chain)) == chain
    assert str(parse_chain(str(chain))) == str(chain)


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("none", "none"),
        (" none ", "none"),
        ("crop:0.1+noise:0.003+similarity", "crop:0.1+noise:0.003+similarity:1"),
        ("noise", "noise:0.005"),
        ("smoothing", "smoothing:15"),
        ("noise:.0050", "noise:0.005"),
        ("noise:5e-05", "noise:5e-05"),
        ("noise:1e+1+crop:0.10", "noise:10+crop:0.1"),
        (" crop:0.1 + mirror ", "crop:0.1+mirror:1"),
        ("quantisation:10.0", "quantisation:10"),
        ("noise:-0", "noise:0"),
    ],
)
def test_texts_have_one_canonical_form(text, canonical):
    assert str(parse_chain(text)) == canonical


@pytest.mark.parametrize("name", ATTACKS)
def test_a_step_without_a_strength_takes_the_middle_one(name):
    strengths = ATTACKS[name].strengths
    assert parse_chain(name).steps == ((name, strengths[(len(strengths) - 1) // 2]),)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "'' is not an attack, expected one of noise, "),
        ("noise:0.1+", "strength '0.1\\+', expected a number"),
        ("+noise", "'' is not an attack|is not an attack"),
        ("noise++crop", "is not an attack"),
        ("none+noise", "'none' is not an attack"),
        ("Noise", "'Noise' is not an attack"),
        ("noise:", "strength '', expected a number"),
        ("noise:loud", "strength 'loud', expected a number"),
        ("noise:0.1:0.2", "expected a number"),
        ("crop:0.1+noise:nan", "noise: strength nan is out of range"),
        ("noise:-1", "noise: strength -1 is out of range"),
        ("quantisation:7.5", "quantisation: strength 7.5 is out of range, expected 0 or a whole number"),
        ("crop:0.1+noize", "'noize' is not an attack"),
    ],
)
def test_texts_that_are_no_chain_are_refused(text, said):
    with pytest.raises(InputError, match=said):
        parse_chain(text)


def test_nothing_is_nothing():
    result = parse_chain("none").apply(MODEL, np.random.default_rng(1))
    assert result.mesh is MODEL
    np.testing.assert_array_equal(result.origin, np.arange(len(MODEL.vertices)))
    assert result.altered is None


@pytest.mark.parametrize("name", ["noise", "crop", "shuffle", "bump", "similarity"])
def test_a_chain_of_one_is_the_attack_itself(name):
    entry = ATTACKS[name]
    alone = entry(MODEL, entry.default, np.random.default_rng(7))
    chained = parse_chain(name)(MODEL, np.random.default_rng(7))
    np.testing.assert_array_equal(alone.vertices, chained.vertices)
    np.testing.assert_array_equal(alone.faces, chained.faces)


def test_a_chain_is_its_steps_with_a_stream_each():
    chain = parse_chain("crop:0.2+noise:0.01+shuffle")
    result = chain.apply(MODEL, np.random.default_rng(3))
    first = np.random.default_rng(3)
    second, third = first.spawn(2)
    a = ATTACKS["crop"].apply(MODEL, 0.2, first)
    b = ATTACKS["noise"].apply(a.mesh, 0.01, second)
    c = ATTACKS["shuffle"].apply(b.mesh, 1, third)
    np.testing.assert_array_equal(result.mesh.vertices, c.mesh.vertices)
    np.testing.assert_array_equal(result.mesh.faces, c.mesh.faces)
    np.testing.assert_array_equal(result.origin, a.origin[c.origin])
    again = chain.apply(MODEL, np.random.default_rng(3))
    np.testing.assert_array_equal(again.mesh.vertices, result.mesh.vertices)


def test_a_step_does_not_depend_on_how_much_an_earlier_one_drew():
    orders = [
        parse_chain(f"{first}+shuffle").apply(MODEL, np.random.default_rng(3)).origin
        for first in ("noise:0", "noise:0.01", "gaussian:0.02", "mirror", "similarity")
    ]
    for order in some(orders[1:]):
        np.testing.assert_array_equal(order, orders[0])


def test_steps_of_one_kind_draw_different_numbers():
    twice = parse_chain("shuffle+shuffle").apply(MODEL, np.random.default_rng(3))
    once = parse_chain("shuffle").apply(MODEL, np.random.default_rng(3))
    assert not np.array_equal(twice.origin, once.origin[once.origin])


def test_the_maps_lead_through_new_vertices_and_new_surfaces():
    refined = parse_chain("midpoint:1+crop:0.3").apply(MODEL, np.random.default_rng(1))
    old = refined.origin >= 0
    np.testing.assert_array_equal(refined.mesh.vertices[old], MODEL.vertices[refined.origin[old]])
    assert (~old).any()


@pytest.mark.parametrize("after", ["shuffle", "unweld", "crop:0.3", "noise:0.001", "similarity", "file_ply"])
def test_altered_vertices_stay_altered_under_other_numbers(after):
    edited = ATTACKS["bump"].apply(MODEL, 0.1, np.random.default_rng(2))
    result = parse_chain(f"bump:0.1+{after}").apply(MODEL, np.random.default_rng(2))
    np.testing.assert_array_equal(result.altered, edited.altered[result.origin])


def test_two_local_edits_add_up():
    one = ATTACKS["bump"].apply(MODEL, 0.05, np.random.default_rng(2)).altered
    both = parse_chain("bump:0.05+dent:0.05").apply(MODEL, np.random.default_rng(2))
    moved = (both.mesh.vertices != MODEL.vertices).any(axis=1)
    assert one.sum() < both.altered.sum()
    np.testing.assert_array_equal(both.altered, moved | one)


@pytest.mark.parametrize("origin", ["none", "some"])
def test_without_a_map_a_vertex_is_altered_where_the_nearest_one_before_was(monkeypatch, origin):
    new = Mesh(*pebble(30))

    def renew(_mesh, _strength, _rng, _given):
        return Attacked(mesh=new, origin=None if origin == "none" else np.full(len(new.vertices), -1))

    monkeypatch.setitem(
        table.ATTACKS, "renew", Attack(function=renew, strengths=(1,), unit="time", imitates="nothing")
    )
    edited = ATTACKS["bump"].apply(MODEL, 0.2, np.random.default_rng(2))
    result = parse_chain("bump:0.2+renew").apply(MODEL, np.random.default_rng(2))
    away = np.linalg.norm(new.vertices[:, None] - edited.mesh.vertices[None], axis=2)
    np.testing.assert_array_equal(result.altered, edited.altered[away.argmin(axis=1)])
    assert 0 < result.altered.mean() < 1


def test_needs_are_told_and_handed_to_the_steps():
    assert parse_chain("collusion:2+noise+paste").needs == {"copies", "donor"}
    assert parse_chain("noise+crop").needs == frozenset()
    held = given_for(MODEL)
    result = parse_chain("collusion:2+noise:0").apply(MODEL, np.random.default_rng(1), held)
    np.testing.assert_allclose(result.mesh.vertices, (MODEL.vertices + held.copies[0].vertices) / 2)
    with pytest.raises(InputError, match="at least one more copy"):
        parse_chain("collusion:2").apply(MODEL, np.random.default_rng(1), Given())


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.sampled_from(["crop:0.2", "shuffle", "unweld", "weld", "noise:0.01", "midpoint"]), max_size=4
    ),
    st.integers(0, 1000),
)
def test_the_map_of_any_chain_names_where_a_vertex_came_from(names, seed):
    """A model whose vertices are far apart is recognised by position, whatever happened."""
    far = Mesh(*pebble(18))
    result = parse_chain("+".join(names) or "none").apply(far, np.random.default_rng(seed))
    old = result.origin >= 0
    reach = 0.01 * names.count("noise:0.01") * 2 * np.sqrt(3)  # 0 without noise: the very place
    away = np.linalg.norm(result.mesh.vertices[old] - far.vertices[result.origin[old]], axis=1)
    assert (away <= reach).all()

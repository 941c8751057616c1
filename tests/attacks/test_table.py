"""What holds for every attack in the table, whatever it does."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import meshmark as mm
from meshmark.attacks import ATTACKS, Attacked, Given, find_attack
from meshmark.errors import InputError
from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from tests.attacks.libraries import need_gpytoolbox
from tests.attacks.models import given_for, odd_strip, seam, seamed
from tests.counting import Share

RANDOM = {
    "voxels",
    "noise", "gaussian", "crop", "similarity", "affine", "shuffle", "bump", "dent", "move_part", "delete_part",
    "replace_part", "paste", "scale_part", "smooth_part", "add_part",
}  # fmt: skip
LOCAL = {
    "bump", "dent", "move_part", "scale_part", "smooth_part", "add_part", "delete_part", "replace_part", "paste",
}  # fmt: skip
# Positions change, faces and numbers do not: a save patches the file.
MOVING = {
    "noise", "gaussian", "smoothing", "smoothing_half", "taubin", "quantisation", "similarity", "affine", "float32",
    "bump", "dent", "move_part", "scale_part", "smooth_part", "paste", "second_mark", "collusion", "copy",
}  # fmt: skip
# New surfaces, whose vertices have no number from before.
ANEW = {"remeshing", "voxels"}
# The strengths that the benchmark's tables need, attack by attack.
STRENGTHS = {
    "noise": {0.0005, 0.001, 0.003, 0.005, 0.01, 0.02, 0.05},
    "gaussian": {0.01, 0.02, 0.05},
    "smoothing": {5, 10, 15, 30, 50},
    "smoothing_half": {5, 10, 15},
    "taubin": {10},
    "quantisation": {16, 12, 11, 10, 9, 8, 7},
    "crop": {0.03, 0.06, 0.09, 0.1, 0.3, 0.5, 0.7},
    "simplification": {0.1, 0.3, 0.5, 0.7, 0.9, 0.95},
    **{name: {1} for name in ("midpoint", "loop", "sqrt3", "remeshing", "similarity", "mirror", "shuffle")},
    "voxels": set(),
    "affine": {0.01, 0.05},
    **{f"file_{name}": {1} for name in mm.io.FORMATS},
    **{name: {1} for name in ("weld", "unweld", "float32", "second_mark", "copy")},
    **{name: set() for name in LOCAL},
    "collusion": {2, 3, 5},
}
MODEL = seamed()
GIVEN = given_for(MODEL)


@cache
def attacked(name: str) -> Attacked:
    if name == "remeshing":
        need_gpytoolbox()
    return ATTACKS[name].apply(MODEL, ATTACKS[name].default, np.random.default_rng(1), GIVEN)


def same(a: Mesh, b: Mesh) -> bool:
    return np.array_equal(a.vertices, b.vertices) and np.array_equal(a.faces, b.faces)


def test_the_table_has_every_attack_and_strength():
    assert STRENGTHS.keys() == ATTACKS.keys()
    for name, strengths in STRENGTHS.items():
        assert strengths <= set(ATTACKS[name].strengths), name


@pytest.mark.parametrize("name", ATTACKS)
def test_strength_0_changes_nothing(name):
    result = ATTACKS[name].apply(MODEL, 0, np.random.default_rng(1))
    assert same(result.mesh, MODEL)
    np.testing.assert_array_equal(result.origin, np.arange(len(MODEL.vertices)))
    assert result.altered is None


@pytest.mark.parametrize("name", ATTACKS)
def test_above_0_something_changes_and_the_input_does_not(name):
    before = MODEL.vertices.copy(), MODEL.faces.copy()
    assert not same(attacked(name).mesh, MODEL)
    np.testing.assert_array_equal(before[0], MODEL.vertices)
    np.testing.assert_array_equal(before[1], MODEL.faces)


def again(name: str, seed: int) -> Mesh:
    return ATTACKS[name](MODEL, ATTACKS[name].default, np.random.default_rng(seed), GIVEN)


@pytest.mark.parametrize("name", sorted(RANDOM))
def test_where_there_is_chance_the_same_seed_gives_the_same_and_another_seed_another(name):
    assert same(attacked(name).mesh, again(name, seed=1))
    assert not same(attacked(name).mesh, again(name, seed=2))


@pytest.mark.parametrize("name", sorted(ATTACKS.keys() - RANDOM))
def test_where_there_is_no_chance_the_seed_does_not_matter(name):
    assert same(attacked(name).mesh, again(name, seed=2))


@pytest.mark.parametrize("name", ATTACKS)
def test_the_maps_fit_the_mesh(name):
    result = attacked(name)
    assert (result.origin is None) == (name in ANEW)
    assert (result.altered is None) == (name not in LOCAL)


@pytest.mark.parametrize("name", sorted(ATTACKS.keys() - ANEW))
def test_every_vertex_has_its_old_number_or_none(name):
    result = attacked(name)
    assert result.origin.shape == (len(result.mesh.vertices),)
    assert -1 <= result.origin.min() <= result.origin.max() < len(MODEL.vertices)


@pytest.mark.parametrize("name", sorted(MOVING))
def test_where_only_positions_change_numbers_and_faces_stay(name):
    result = attacked(name)
    np.testing.assert_array_equal(result.origin, np.arange(len(MODEL.vertices)))
    np.testing.assert_array_equal(result.mesh.faces, MODEL.faces)


@pytest.mark.parametrize("name", sorted(LOCAL))
def test_local_edits_leave_all_else_bit_by_bit(name):
    result = attacked(name)
    assert result.altered.shape == (len(result.mesh.vertices),)
    assert 0 < result.altered.mean() < 0.5
    still = ~result.altered
    assert (result.origin[still] >= 0).all()
    np.testing.assert_array_equal(result.mesh.vertices[still], MODEL.vertices[result.origin[still]])


@pytest.mark.parametrize("name", sorted(MOVING))
def test_seams_do_not_tear(name):
    first, second = seam(MODEL)
    assert len(first) > 20
    moved = attacked(name).mesh.vertices
    np.testing.assert_array_equal(moved[first], moved[second])


@pytest.mark.parametrize("name", sorted(ANEW))
def test_a_new_surface_has_no_document(name):
    assert attacked(name).mesh.document is None


@pytest.mark.parametrize("name", sorted(ATTACKS.keys() - ANEW))  # those are slow, and alike for any mesh
def test_a_model_from_a_file_keeps_its_document_where_only_positions_change(name, tmp_path):
    write_mesh(MODEL, tmp_path / "model.ply")
    mesh = mm.read_mesh(tmp_path / "model.ply")
    result = ATTACKS[name](mesh, ATTACKS[name].default, np.random.default_rng(1), GIVEN)
    assert (result.document is mesh.document) == (name in MOVING)
    assert result.document is mesh.document or result.document is None
    write_mesh(result, tmp_path / "attacked.ply")
    assert same(mm.read_mesh(tmp_path / "attacked.ply"), result)


@pytest.mark.parametrize("name", ATTACKS)
def test_every_strength_of_the_table_is_taken(name):
    entry = ATTACKS[name]
    for value in entry.strengths:
        entry.check(value)
    assert len(set(entry.strengths)) == len(entry.strengths)
    assert entry.default in entry.strengths


ODD = {
    "an open strip with a lone vertex": odd_strip(),
    "no faces": Mesh(np.random.default_rng(3).normal(size=(9, 3)), np.empty((0, 3))),
    "one triangle": Mesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "one vertex": Mesh([[1.0, 2.0, 3.0]], np.empty((0, 3))),
    "all in one place": Mesh(np.ones((4, 3)), [[0, 1, 2], [1, 2, 3]]),
    "extreme units": Mesh(1e30 * odd_strip().vertices, odd_strip().faces),
    "tiny units": Mesh(1e-30 * odd_strip().vertices, odd_strip().faces),
}
# The least share of attacks that take such a model; the others refuse it.
ATTACKED = dict.fromkeys(ODD, 0.3)
EMPTY = Mesh(np.empty((0, 3)), np.empty((0, 3)))


@pytest.mark.parametrize("name", sorted(ATTACKS.keys() - {"remeshing"}))
def test_a_model_without_vertices_is_refused_in_one_sentence(name):
    with pytest.raises(InputError, match=r"\A[^\n]{20,}\Z"):
        ATTACKS[name](EMPTY, ATTACKS[name].default, np.random.default_rng(1), given_for(EMPTY))


@pytest.mark.parametrize("case", ODD)
def test_odd_models_are_attacked_or_refused_in_one_sentence(case):
    mesh, refusals = ODD[case], []
    with Share(ATTACKED[case]) as share:
        for name in sorted(ATTACKS.keys() - {"remeshing"}):
            entry = ATTACKS[name]
            share.case()
            try:
                result = entry.apply(mesh, entry.default, np.random.default_rng(1), given_for(mesh))
            except InputError as error:
                refusals.append(str(error))
                continue
            share.asserted()
            assert len(result.mesh.vertices), name
            assert len(result.mesh.faces) or not len(mesh.faces) or case == "all in one place", name
            assert result.origin is None or result.origin.shape == (len(result.mesh.vertices),), name
    assert [each for each in refusals if not re.fullmatch(r"[^\n]{20,}", each)] == []


@pytest.mark.parametrize("name", ATTACKS)
@pytest.mark.parametrize("strength", [-1.0, float("nan"), float("inf"), -0.001])
def test_strengths_that_are_none_are_refused(name, strength):
    with pytest.raises(InputError, match="out of range, expected 0 or"):
        ATTACKS[name](MODEL, strength, np.random.default_rng(1), GIVEN)


@pytest.mark.parametrize(
    ("name", "strength"),
    [
        ("quantisation", 7.5), ("quantisation", 53), ("smoothing", 0.5), ("crop", 1.5), ("simplification", 1.1),
        ("mirror", 2), ("mirror", 0.5), ("collusion", 1), ("collusion", 2.5), ("similarity", 1.01), ("loop", 1.5),
    ],
)  # fmt: skip
def test_strengths_outside_the_range_of_the_attack_are_refused(name, strength):
    with pytest.raises(InputError, match="out of range, expected 0 or"):
        ATTACKS[name](MODEL, strength, np.random.default_rng(1), GIVEN)


@pytest.mark.parametrize("name", [name for name, entry in ATTACKS.items() if entry.needs])
def test_what_an_attack_needs_is_asked_for(name):
    for given in (None, Given()):
        with pytest.raises(InputError, match="expected"):
            ATTACKS[name](MODEL, ATTACKS[name].default, np.random.default_rng(1), given)


def test_an_unknown_name_is_refused_with_the_valid_ones():
    with pytest.raises(
        InputError, match=r"'nonsense' is not an attack, expected one of noise, gaussian, .*copy"
    ):
        find_attack("nonsense")
    assert find_attack("noise") is mm.ATTACKS["noise"]

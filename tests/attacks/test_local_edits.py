"""Local edits: what they touch, what they leave bit by bit, and the shapes that their definitions promise."""

from __future__ import annotations

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.attacks.attack import Given
from meshmark.attacks.local_add import add_part
from meshmark.attacks.local_delete import delete_part
from meshmark.attacks.local_move import ANGLE, FACTOR, SHIFT, STIFF, move_part, scale_part
from meshmark.attacks.local_patch import draw_patch
from meshmark.attacks.local_relief import HEIGHT, bump, dent
from meshmark.attacks.local_replace import replace_part
from meshmark.attacks.local_smooth import smooth_part
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.surfaces import border, euler, is_closed, sheet, unwelded, volume
from tests.counting import some
from tests.shapes import pebble

MESH = Mesh(*pebble(30))
COUNT = len(MESH.vertices)
MOVING = pytest.mark.parametrize("attack", [bump, dent, move_part, scale_part, smooth_part])
ALL = pytest.mark.parametrize(
    "attack", [bump, dent, move_part, scale_part, smooth_part, add_part, delete_part, replace_part]
)
SHARES = pytest.mark.parametrize("share", [0.01, 0.03, 0.1, 0.3])


def edited(attack, mesh: Mesh, share: float = 0.05, seed: int = 3):
    return attack(mesh, share, np.random.default_rng(seed), Given())


def patch_of(mesh: Mesh, share: float = 0.05, seed: int = 3):
    return draw_patch(mesh, share, np.random.default_rng(seed))


@SHARES
def test_a_patch_holds_the_share_that_is_nearest_along_the_edges(share):
    patch = patch_of(MESH, share)
    graph = networkx.Graph()
    for a, b, c in MESH.faces.tolist():
        for one, other in ((a, b), (b, c), (c, a)):
            graph.add_edge(one, other, weight=np.linalg.norm(MESH.vertices[one] - MESH.vertices[other]))
    far = networkx.single_source_dijkstra_path_length(graph, int(patch.members[0]))
    assert len(patch.members) == round(share * COUNT)
    inside = set(patch.members.tolist())
    assert max(far[v] for v in inside) <= min(far[v] for v in range(COUNT) if v not in inside) + 1e-12
    np.testing.assert_allclose(
        patch.reach * patch.radius, [far[v] for v in patch.members.tolist()], atol=1e-12
    )
    assert (patch.reach < 1.0).all()
    assert np.linalg.norm(patch.normal) == pytest.approx(1.0)
    assert patch.normal @ (patch.points.mean(axis=0) - MESH.vertices.mean(axis=0)) > 0  # outwards


def test_centres_differ_and_cover_the_model():
    centres = {int(patch_of(MESH, 0.01, seed).members[0]) for seed in range(60)}
    assert len(centres) > 50
    assert np.ptp(MESH.vertices[list(centres)], axis=0).min() > 0.8 * np.ptp(MESH.vertices, axis=0).min()


@ALL
@SHARES
def test_everything_outside_stays_bit_by_bit(attack, share):
    result = edited(attack, MESH, share)
    still = ~result.altered
    np.testing.assert_array_equal(result.mesh.vertices[still], MESH.vertices[result.origin[still]])
    assert result.altered.any()
    assert result.altered.shape == result.origin.shape == (len(result.mesh.vertices),)
    assert len(np.unique(result.mesh.faces)) == len(result.mesh.vertices)  # no loose vertex is left


@MOVING
@SHARES
def test_exactly_the_patch_moves(attack, share):
    result = edited(attack, MESH, share)
    assert set(np.flatnonzero(result.altered)) == set(patch_of(MESH, share).members.tolist())
    moved = (result.mesh.vertices != MESH.vertices).any(axis=1)
    np.testing.assert_array_equal(moved, result.altered)
    assert np.shares_memory(result.mesh.faces, MESH.faces)
    np.testing.assert_array_equal(result.origin, np.arange(COUNT))


@pytest.mark.parametrize(("attack", "side"), [(bump, 1.0), (dent, -1.0)])
def test_bump_and_dent_follow_their_formula(attack, side):
    patch, result = patch_of(MESH), edited(attack, MESH)
    steps = (result.mesh.vertices - MESH.vertices)[patch.members]
    assert side * steps[0] @ patch.normal == pytest.approx(HEIGHT * patch.radius)
    np.testing.assert_allclose(steps @ patch.normal, side * HEIGHT * patch.radius * (1 - patch.reach**2) ** 2)
    np.testing.assert_allclose(np.cross(steps, patch.normal), 0.0, atol=1e-12)
    assert side * (volume(result.mesh) - volume(MESH)) > 0


def test_the_inner_part_moves_rigidly():
    patch, result = patch_of(MESH, 0.1), edited(move_part, MESH, 0.1)
    core = patch.members[patch.reach <= STIFF]
    before, after = MESH.vertices[core], result.mesh.vertices[core]
    apart = [np.linalg.norm(places[:, None] - places, axis=2) for places in (before, after)]
    np.testing.assert_allclose(*apart, atol=1e-12)
    u, _, v = np.linalg.svd((before - before.mean(axis=0)).T @ (after - after.mean(axis=0)))
    turn = (u @ v).T
    assert np.arccos((np.trace(turn) - 1) / 2) == pytest.approx(ANGLE)
    pivot = patch.points.mean(axis=0)
    shift = after[0] - pivot - turn @ (before[0] - pivot)
    assert np.linalg.norm(shift) == pytest.approx(SHIFT * patch.radius)
    boundary = np.linalg.norm(result.mesh.vertices[patch.members[-1]] - MESH.vertices[patch.members[-1]])
    assert boundary < 0.1 * np.linalg.norm(shift)


def test_the_inner_part_is_scaled_about_its_middle():
    patch, result = patch_of(MESH, 0.1), edited(scale_part, MESH, 0.1)
    core = patch.members[patch.reach <= STIFF]
    middle = patch.points.mean(axis=0)
    np.testing.assert_allclose(
        result.mesh.vertices[core] - middle, FACTOR * (MESH.vertices[core] - middle), rtol=0, atol=1e-12
    )


@SHARES
def test_delete_takes_the_patch_and_marks_the_boundary(share):
    patch, result = patch_of(MESH, share), edited(delete_part, MESH, share)
    gone = set(patch.members.tolist())
    kept_faces = [face for face in MESH.faces.tolist() if not gone & set(face)]
    assert result.origin[result.mesh.faces].tolist() == kept_faces
    assert not gone & set(result.origin.tolist())
    boundary = {vertex for edge in border(result.mesh) for vertex in edge}
    assert set(np.flatnonzero(result.altered)) == boundary
    assert result.mesh.document is None


@SHARES
def test_replaced_part_fits_the_boundary(share):
    patch, result = patch_of(MESH, share), edited(replace_part, MESH, share)
    assert is_closed(result.mesh)
    assert euler(result.mesh) == 2
    np.testing.assert_array_equal(result.altered, result.origin == -1)
    assert set(range(COUNT)) - set(result.origin.tolist()) == set(patch.members.tolist())
    old = np.isin(MESH.faces, patch.members).any(axis=1).sum()
    assert len(result.mesh.faces) == len(MESH.faces) + 2 * old
    assert result.altered.sum() == old + len(patch.members)
    new = result.mesh.vertices[result.altered]
    apart = np.linalg.norm(new[:, None] - MESH.vertices, axis=2).min(axis=1)
    assert np.median(apart) > 0.0
    assert np.linalg.norm(new - patch.points.mean(axis=0), axis=1).max() < 1.5 * patch.radius


@ALL
def test_same_seed_same_result_and_others_differ(attack):
    one, again, other = edited(attack, MESH), edited(attack, MESH), edited(attack, MESH, seed=4)
    np.testing.assert_array_equal(one.mesh.vertices, again.mesh.vertices)
    np.testing.assert_array_equal(one.mesh.faces, again.mesh.faces)
    assert not np.array_equal(one.mesh.vertices[one.altered], other.mesh.vertices[other.altered])


@ALL
@pytest.mark.parametrize("scale", [2.0**-60, 2.0**17, 2.0**90])
def test_any_unit_gives_the_same_edit(attack, scale):
    here, there = edited(attack, MESH), edited(attack, Mesh(MESH.vertices * scale, MESH.faces))
    np.testing.assert_array_equal(there.mesh.faces, here.mesh.faces)
    np.testing.assert_allclose(there.mesh.vertices / scale, here.mesh.vertices, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(there.altered, here.altered)


@ALL
def test_vertices_that_coincide_stay_together(attack):
    split, whole = edited(attack, unwelded(MESH)), edited(attack, MESH)
    corners = [
        np.sort(result.mesh.vertices[result.mesh.faces].reshape(-1, 9), axis=0) for result in (split, whole)
    ]
    assert corners[0].shape == corners[1].shape
    places: dict[tuple[float, ...], set[bool]] = {}
    for place, marked in zip(split.mesh.vertices.tolist(), split.altered.tolist(), strict=True):
        places.setdefault(tuple(place), set()).add(marked)
    assert all(len(marks) == 1 for marks in some(places.values()))
    assert len(places) == len(whole.mesh.vertices)


@ALL
def test_a_model_in_many_parts_and_a_flat_one(attack):
    pieces = unwelded(MESH)
    loose = Mesh(pieces.vertices + np.repeat(np.arange(len(pieces.faces)), 3)[:, None], pieces.faces)
    for mesh in (loose, Mesh(*sheet(12))):
        result = edited(attack, mesh, 0.1)
        assert np.isfinite(result.mesh.vertices).all()
        whole_parts_went = attack is delete_part and mesh is loose
        assert result.altered.any() != whole_parts_went


@ALL
def test_bad_shares_and_meshes_are_refused(attack):
    with pytest.raises(InputError, match="share of the vertices below 1"):
        edited(attack, MESH, 1.0)
    with pytest.raises(InputError, match="the model has no faces"):
        edited(attack, Mesh(MESH.vertices, np.zeros((0, 3), int)))


def test_deleting_all_faces_is_refused():
    with pytest.raises(InputError, match="leaves no face"):
        edited(delete_part, MESH, 0.999)


@settings(max_examples=30, deadline=None)
@given(share=st.floats(1e-4, 0.9), seed=st.integers(0, 2**32))
def test_any_share_and_seed(share, seed):
    for attack in (bump, dent, move_part):
        result = edited(attack, MESH, share, seed)
        assert result.altered.sum() == max(round(share * COUNT), 1)
    replaced = edited(replace_part, MESH, share, seed)
    assert is_closed(replaced.mesh)
    assert np.isfinite(replaced.mesh.vertices).all()

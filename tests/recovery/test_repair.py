from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshmark.attacks import ATTACKS, Given
from meshmark.attacks.attack import Attacked
from meshmark.errors import InputError
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.recovery.miniature import miniature
from meshmark.recovery.repair import Recovered, recover
from tests.shapes import pebble


@pytest.fixture(scope="module")
def model() -> Mesh:
    points, faces = pebble(72)
    return Mesh(points, faces)


@pytest.fixture(scope="module")
def small(model) -> bytes:
    return miniature(model.vertices, model.faces, len(model.vertices) // 8)


def watertight(faces: np.ndarray) -> bool:
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def error(model: Mesh, points: np.ndarray, faces: np.ndarray) -> float:
    """RMS distance over the diagonal, over vertices, of both directions' worse one."""
    there = SurfaceIndex(model.vertices, model.faces).nearest(points[np.unique(faces)]).distances
    back = SurfaceIndex(points, faces).nearest(model.vertices).distances
    size = np.linalg.norm(np.ptp(model.vertices, axis=0))
    return float(np.sqrt(max(np.mean(there**2), np.mean(back**2))) / size)


def recovered(attacked: Attacked, content: bytes) -> tuple[Surface, np.ndarray, Recovered]:
    suspect = weld(attacked.mesh)
    altered = np.zeros(len(suspect.points), bool)
    altered[suspect.point_of_vertex[attacked.altered]] = True
    return suspect, altered, recover(suspect, altered, content)


@pytest.mark.parametrize(
    ("name", "share"),
    [
        ("bump", 0.02),
        ("delete_part", 0.02),
        *((name, 0.2) for name in ("dent", "move_part", "delete_part", "replace_part", "paste")),
    ],
)
def test_edits_are_taken_back(model, small, name, share):
    donor = Mesh(*pebble(50))
    attacked = ATTACKS[name].apply(model, share, np.random.default_rng(3), Given(donor=donor))
    suspect, altered, found = recovered(attacked, small)
    before, after = error(model, suspect.points, suspect.faces), error(model, found.points, found.faces)
    assert after < 0.002
    assert after < before / 4
    assert watertight(found.faces)
    kept = found.origin >= 0
    same = kept & ~found.moved
    assert np.array_equal(found.points[same], suspect.points[found.origin[same]])
    assert not found.moved[kept & ~altered[found.origin]].any()
    assert set(np.flatnonzero(~altered)) <= set(found.origin[kept])


def test_faces_that_stay_are_the_suspects_own(model, small):
    attacked = ATTACKS["delete_part"].apply(model, 0.05, np.random.default_rng(4))
    suspect, _, found = recovered(attacked, small)
    assert np.array_equal(found.origin[found.faces[~found.added]], suspect.faces)
    assert found.added.any()
    assert (found.origin[found.faces[found.added]] < 0).any(axis=1).mean() > 0.9


@pytest.mark.parametrize("seed", range(2))
def test_a_turned_scaled_and_moved_suspect_is_recovered_alike(model, small, seed):
    attacked = ATTACKS["bump"].apply(model, 0.1, np.random.default_rng(seed))
    turn = Rotation.random(random_state=seed).as_matrix()

    def placed(points: np.ndarray) -> np.ndarray:
        return 0.1 * points @ turn.T + [5.0, -3.0, 1.0]

    moved = Attacked(
        mesh=Mesh(placed(attacked.mesh.vertices), model.faces),
        origin=attacked.origin,
        altered=attacked.altered,
    )
    _, _, found = recovered(moved, small)
    assert error(Mesh(placed(model.vertices), model.faces), found.points, found.faces) < 0.002


def test_without_alterations_nothing_changes(model, small):
    suspect = weld(model)
    found = recover(suspect, np.zeros(len(suspect.points), bool), small)
    assert np.array_equal(found.points, suspect.points)
    assert np.array_equal(found.faces, suspect.faces)
    assert not found.moved.any()
    assert not found.added.any()


def test_points_called_altered_that_are_as_they_were_hardly_move(model, small):
    suspect = weld(model)
    altered = np.zeros(len(suspect.points), bool)
    altered[:200] = True
    found = recover(suspect, altered, small)
    assert error(model, found.points, found.faces) < 0.0015


@pytest.mark.parametrize(
    ("name", "share"), [("smooth_part", 0.05), ("scale_part", 0.02), ("smooth_part", 0.02)]
)
def test_what_is_less_than_the_miniature_tells_gets_no_worse_and_is_said(model, name, share):
    coarse = miniature(model.vertices, model.faces, 140)
    attacked = ATTACKS[name].apply(model, share, np.random.default_rng(3), Given())
    suspect, _, found = recovered(attacked, coarse)
    before, after = error(model, suspect.points, suspect.faces), error(model, found.points, found.faces)
    assert 0.0 < after <= before
    assert found.left == 1
    assert not found.moved.any()


def test_a_component_of_which_nothing_is_left_returns_where_points_are_known_to_be_missing(model):
    other, faces = pebble(40)
    both = Mesh(
        np.concatenate([model.vertices, 0.4 * other + [3.0, 1.0, 0.5]]),
        np.concatenate([model.faces, faces + len(model.vertices)]),
    )
    content = miniature(both.vertices, both.faces, len(both.vertices) // 6)
    suspect, intact = weld(model), np.zeros(len(model.vertices), bool)
    assert len(recover(suspect, intact, content).faces) == len(model.faces)
    found = recover(suspect, intact, content, missing=True)
    assert error(both, found.points, found.faces) < 0.003
    assert watertight(found.faces)
    assert not found.moved.any()
    assert np.array_equal(found.origin >= 0, np.arange(len(found.points)) < len(model.vertices))
    whole = recover(weld(both), np.zeros(len(both.vertices), bool), content, missing=True)
    assert not whole.added.any()


def test_inputs_stay_as_they_are_and_the_answer_repeats(model, small):
    attacked = ATTACKS["dent"].apply(model, 0.05, np.random.default_rng(6))
    suspect, altered, first = recovered(attacked, small)
    for array in (suspect.points, suspect.faces, altered):
        array.flags.writeable = False
    again = recover(suspect, altered, small)
    assert np.array_equal(first.points, again.points)
    assert np.array_equal(first.faces, again.faces)


def test_what_does_not_belong_together_is_refused(model, small):
    suspect = weld(model)
    with pytest.raises(InputError, match="called altered or not"):
        recover(suspect, np.zeros(3, bool), small)
    with pytest.raises(InputError, match="are intact"):
        recover(suspect, np.ones(len(suspect.points), bool), small)
    with pytest.raises(InputError, match="no miniature"):
        recover(suspect, np.zeros(len(suspect.points), bool), b"\xff\xff")

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.register import KEPT, register
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.counting import some
from tests.geometry.registering import any_similarity, distance, in_scene, lump, reference
from tests.shapes import pebble

CHAINS = (
    "none",
    "noise:0.02",
    "smoothing:5",
    "quantisation:7",
    "crop:0.3",
    "crop:0.5",
    "crop:0.1+noise:0.003",
)


@pytest.mark.parametrize("chain", CHAINS)
def test_the_pose_of_an_attacked_and_moved_lump_is_found(chain):
    landmarks, home = reference()
    attacked = parse_chain(chain)(Mesh(*lump()), np.random.default_rng(5))
    move = any_similarity(len(chain))
    moved = weld(Mesh(move(attacked.vertices), attacked.faces))
    found = register(landmarks, home, PreparedSurface(moved.points, moved.faces))
    true = move.after(in_scene(home))
    assert distance(found[0].pose, true, landmarks.places) < 0.01
    assert found[0].explained > 0.8
    assert len(found) <= KEPT
    assert [fit.quality for fit in found] == sorted((fit.quality for fit in found), reverse=True)


def test_an_untouched_model_is_found_to_the_last_digits_that_pieces_allow():
    landmarks, home = reference()
    best = register(landmarks, home, PreparedSurface(*lump()))[0]
    assert distance(best.pose, in_scene(home), landmarks.places) < 1e-3
    assert best.share > 0.95
    assert best.rms < 1e-3


def test_the_same_input_gives_the_same_poses():
    landmarks, home = reference()
    attacked = parse_chain("crop:0.4+similarity")(Mesh(*lump(48)), np.random.default_rng(1))
    surface = weld(attacked)
    one, other = (register(landmarks, home, PreparedSurface(surface.points, surface.faces)) for _ in range(2))
    assert len(one) == len(other) > 0
    for a, b in some(zip(one, other, strict=True)):
        np.testing.assert_array_equal(a.pose(landmarks.places), b.pose(landmarks.places))


def test_another_model_is_not_taken_for_the_reference():
    landmarks, home = reference()
    points, faces = pebble(48)
    found = register(landmarks, home, PreparedSurface(points * [1.0, 0.4, 2.0], faces))
    assert [fit for fit in found if fit.quality >= 0.7] == []


def sphere() -> tuple[np.ndarray, np.ndarray]:
    points, faces = pebble(60)
    return points / np.linalg.norm(points, axis=1)[:, None], faces


def cylinder() -> tuple[np.ndarray, np.ndarray]:
    points, faces = sphere()
    return points * [1.0, 1.0, 3.0], faces


def plane() -> tuple[np.ndarray, np.ndarray]:
    axis = np.linspace(-1.0, 1.0, 20)
    points = np.stack(np.meshgrid(axis, 1.5 * axis, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = (np.arange(19)[:, None] * 20 + np.arange(19)).ravel()
    faces = [[corner, corner + 20, corner + 1], [corner + 20, corner + 21, corner + 1]]
    return points, np.concatenate([np.column_stack(three) for three in faces])


@pytest.mark.parametrize("shape", [sphere, cylinder, plane])
def test_what_does_not_determine_a_pose_gives_none(shape):
    points, faces = shape()
    surface = PreparedSurface(points, faces)
    assert register(surface.landmarks(200), surface.frame, surface) == []


def test_a_single_triangle_gives_none():
    landmarks, home = reference()
    triangle = PreparedSurface(np.eye(3), np.array([[0, 1, 2]]))
    assert register(landmarks, home, triangle) == []
    assert register(triangle.landmarks(200), triangle.frame, PreparedSurface(*lump())) == []

"""Which point of a whole each point of a damaged copy is."""

from __future__ import annotations

import numpy as np

from meshmark.recovery.same_points import corner_sets, grown_over_faces, same_places
from tests.shapes import pebble


def shuffled(seed: int):
    """A pebble, the same in another order, and the point of the first that each of the second is."""
    points, faces = pebble(24)
    order = np.random.default_rng(seed).permutation(len(points))
    place = np.argsort(order)
    return points, faces, points[order], place[faces], order


def test_points_in_their_places_are_found_and_no_others():
    points, _, copy, _, order = shuffled(1)
    moved = np.arange(len(copy)) % 7 == 0
    copy = copy + 0.02 * moved[:, None]
    match = same_places(copy, points, 1e-3)
    assert np.array_equal(match, np.where(moved, -1, order))


def test_of_two_points_in_one_place_the_nearer_is_the_one():
    whole = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    copy = np.array([[0.01, 0.0, 0.0], [0.002, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert same_places(copy, whole, 0.1).tolist() == [-1, 0, 1]


def test_one_known_face_gives_the_rest_of_a_component():
    _, faces, _, copy_faces, order = shuffled(2)
    match = np.full(len(order), -1)
    match[copy_faces[0]] = order[copy_faces[0]]
    assert np.array_equal(grown_over_faces(match, copy_faces, faces), order)


def test_no_point_of_the_whole_is_named_twice_where_the_faces_differ():
    _, faces, _, copy_faces, order = shuffled(3)
    copy_faces = copy_faces.copy()
    copy_faces[::9] = np.random.default_rng(4).integers(0, len(order), copy_faces[::9].shape)
    match = np.full(len(order), -1)
    match[copy_faces[1]] = order[copy_faces[1]]
    grown = grown_over_faces(match, copy_faces, faces)
    named = grown[grown >= 0]
    assert len(named) > 100
    assert len(np.unique(named)) == len(named)


def test_faces_of_the_same_points_are_equal_in_any_order():
    sets = corner_sets(np.array([[1, 2, 3], [3, 1, 2], [3, 2, 1], [1, 2, 4]]))
    assert (sets == sets[0]).tolist() == [True, True, True, False]

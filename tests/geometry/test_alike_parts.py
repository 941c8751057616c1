"""Copies of one mesh among the connected parts of a surface."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.congruence import Tolerance
from meshmark.geometry.connected import Parts
from meshmark.geometry.copies import find_copies
from tests.copies_samples import placed
from tests.shapes import pebble

EXACT = Tolerance(0.0, 4e-7)
POINTS, FACES = pebble(24)
COUNT = len(POINTS)


def scene(*matrices):
    points = [POINTS @ matrix[:3, :3].T + matrix[:3, 3] for matrix in matrices]
    return np.concatenate(points), np.concatenate([FACES + i * COUNT for i in range(len(matrices))])


def test_the_largest_is_the_original_and_the_maps_lead_to_the_others():
    points, faces = scene(placed((0, 0, 0), 1, 0.5), placed((4, 0, 0), 2), placed((8, 0, 0), 3, 0.8, True))
    found = find_copies(points, Parts(points, faces), 64, EXACT)
    assert (found.place.reshape(3, -1) == [[1], [0], [2]]).all()
    np.testing.assert_array_equal(found.original.reshape(3, -1) % COUNT, [np.arange(COUNT)] * 3)
    assert (found.original // COUNT == 1).all()
    for number in (1, 2):
        rows = found.place == number
        np.testing.assert_allclose(found.maps[number](points[found.original[rows]]), points[rows], atol=1e-9)


def test_copies_are_found_whatever_the_order_of_their_points():
    points, faces = scene(np.eye(4), placed((4, 0, 0), 2, 0.9))
    order = np.concatenate([np.arange(COUNT), COUNT + np.random.default_rng(3).permutation(COUNT)])
    rank = np.argsort(order)
    found = find_copies(points[order], Parts(points[order], rank[faces]), 64, EXACT)
    np.testing.assert_array_equal(order[found.original[COUNT:]], order[COUNT:] - COUNT)


def test_small_parts_belong_to_the_copy_that_they_lie_about():
    leaf = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    corners = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    tree = np.concatenate([POINTS, leaf + np.array([2, 0, 0]), leaf + np.array([0, 2, 0])])
    faces = np.concatenate([FACES, corners + COUNT, corners + COUNT + 4])
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    rows = []
    for turns in range(4):  # each turn takes the copies onto each other
        rows.append((tree + np.array([6, 1, 0])) @ np.linalg.matrix_power(quarter, turns).T)
    points = np.concatenate(rows)
    parts = Parts(points, np.concatenate([faces + i * len(tree) for i in range(4)]))
    found = find_copies(points, parts, 64, EXACT)
    places = found.place.reshape(4, -1)
    assert (places == places[:, :1]).all()
    assert sorted(places[:, 0]) == [0, 1, 2, 3]


@pytest.mark.parametrize("cut", [False, True])
def test_a_changed_copy_is_found_only_where_it_is_asked_for(cut):
    points, faces = scene(np.eye(4), placed((4, 0, 0), 2, 0.9, True))
    near = np.linalg.norm(points - points[COUNT + 80], axis=1) < 0.3
    if cut:
        faces = faces[~near[faces].any(axis=1)]
    else:
        points = points + near[:, None] * [0.1, 0, 0]
    assert find_copies(points, Parts(points, faces), 64, EXACT) is None
    found = find_copies(points, Parts(points, faces), 64, EXACT, edited="cut" if cut else "moved")
    used = np.isin(np.arange(2 * COUNT), faces)
    assert (found.place[used] == np.repeat([0, 1], COUNT)[used]).all()


def test_parts_that_differ_by_what_a_mark_moves_are_no_copies():
    points, faces = scene(np.eye(4), placed((4, 0, 0), 2))
    points[COUNT:] += 1e-3 * np.random.default_rng(5).normal(size=(COUNT, 3))
    assert find_copies(points, Parts(points, faces), 64, Tolerance(3e-4, 2e-6)) is None
    assert find_copies(POINTS, Parts(POINTS, FACES), 64, EXACT) is None

from __future__ import annotations

import numpy as np
import pytest

from meshmark.recovery.borders import border_edges
from meshmark.recovery.simplify import simplify
from tests.recovery.surfaces import area, euler, grid, off, turned_first
from tests.shapes import hoop, pebble, sphere_with_a_spike

TETRAHEDRON = (
    np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
    np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]),
)


@pytest.mark.parametrize("count", [20, 60, 200])
def test_simplification_stays_closed_and_near(count):
    points, faces = pebble(48)
    few, small = simplify(points, faces, count)
    assert len(few) == count
    assert not len(border_edges(small))
    assert euler(small) == 2  # still a sphere
    assert np.sqrt((off(few, small, points) ** 2).mean()) < 1.6 / count


def test_simplification_keeps_borders_in_place():
    points, faces, _ = sphere_with_a_spike(24)
    part = faces[(points[faces][:, :, 2] > 0.1).all(axis=1)]
    few, small = simplify(points, part, 40)
    boundary = few[np.unique(border_edges(small))]
    low = points[part][:, :, 2].min()
    assert len(boundary) >= 6
    assert np.abs(boundary[:, 2] - low).max() < 0.05
    assert euler(small) == 1  # still a disc


def test_a_flat_square_keeps_its_place_its_corners_and_its_area():
    points, faces = grid(12)
    few, small = simplify(points, faces, 20)
    assert len(few) == 20
    assert np.abs(few[:, 2]).max() < 1e-12
    corners = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    assert np.linalg.norm(corners[:, None] - few, axis=2).min(axis=1).max() < 1e-9
    assert area(few, small) == pytest.approx(1.0)


def test_a_ring_stays_a_ring():
    points, faces = hoop(long=60, around=8, thin=0.3)
    few, small = simplify(points, faces, 60)
    assert len(few) == 60
    assert not len(border_edges(small))
    assert euler(small) == 0


def test_a_tetrahedron_gets_no_simpler():
    few, small = simplify(*TETRAHEDRON, 1)
    assert np.array_equal(few, TETRAHEDRON[0])
    assert turned_first(small) == turned_first(TETRAHEDRON[1])


def test_an_edge_of_three_faces_keeps_them():
    points, faces = pebble(24)
    a, b = faces[40, :2]
    fin = np.concatenate([points, [2.0 * points[a]]]), np.concatenate([faces, [[b, a, len(points)]]])
    few, small = simplify(*fin, 40)
    sides = np.sort(small[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, times = np.unique(sides, axis=0, return_counts=True)
    assert len(edges[times == 3]) == 1
    assert np.linalg.norm(few[edges[times == 3][0]].mean(axis=0) - points[[a, b]].mean(axis=0)) < 0.1


def test_inputs_stay_as_they_are_and_the_answer_repeats():
    points, faces = pebble(24)
    points.setflags(write=False)
    faces.setflags(write=False)
    one, other = simplify(points, faces, 50), simplify(points, faces, 50)
    assert np.array_equal(one[0], other[0])
    assert np.array_equal(one[1], other[1])


def test_where_it_lies_and_how_large_it_is_does_not_matter():
    points, faces = pebble(24)
    few, small = simplify(points, faces, 50)
    moved, others = simplify(64.0 * points + [128.0, -256.0, 64.0], faces, 50)
    assert len(moved) == len(few)
    assert off(64.0 * few + [128.0, -256.0, 64.0], small, moved).max() < 64.0 * 0.1
    assert euler(others) == euler(small) == 2

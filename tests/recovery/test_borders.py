from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.recovery.borders import border_edges, fan, loops, strip
from tests.counting import some
from tests.recovery.surfaces import area, area_vector, grid
from tests.shapes import pebble, sphere_with_a_spike


def ring(count: int, radius: float) -> np.ndarray:
    turn = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)


def line(count: int, y: float) -> np.ndarray:
    return np.column_stack([np.linspace(0.0, 3.0, count), np.full(count, y), np.zeros(count)])


def walked(loop: np.ndarray) -> list[tuple[int, int]]:
    return list(zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True))


@given(st.data())
def test_border_edges_are_those_that_no_face_walks_back(data):
    faces = sphere_with_a_spike(14)[1]
    kept = data.draw(st.lists(st.integers(0, len(faces) - 1), min_size=1, unique=True))
    edges = [pair for face in faces[kept].tolist() for pair in zip(face, face[1:] + face[:1], strict=True)]
    expected = sorted((a, b) for a, b in edges if (b, a) not in edges)
    assert sorted(map(tuple, border_edges(faces[kept]).tolist())) == expected


def test_a_closed_surface_has_no_border():
    assert border_edges(pebble(24)[1]).shape == (0, 2)


def test_border_loops_are_simple_and_all_edges_are_in_one():
    points, faces, _ = sphere_with_a_spike(24)
    keep = (np.abs(points[faces][:, :, 2]) < 0.5).all(axis=1)
    edges = border_edges(faces[keep])
    found = loops(edges)
    assert len(found) == 2
    assert {pair for loop in found for pair in walked(loop)} == {tuple(edge) for edge in edges.tolist()}


def test_walks_that_meet_in_a_point_part_there():
    eight = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]])
    found = loops(eight)
    assert sorted(sorted(loop.tolist()) for loop in found) == [[0, 1, 2], [0, 3, 4]]
    assert {pair for loop in found for pair in walked(loop)} == {tuple(edge) for edge in eight.tolist()}


def test_broken_walks_and_walks_of_two_are_left_out():
    assert loops(np.array([[0, 1], [1, 2], [2, 3]])) == []
    assert loops(np.array([[0, 1], [1, 0]])) == []
    (only,) = loops(np.array([[7, 0], [0, 1], [1, 2], [2, 0]]))
    assert sorted(only.tolist()) == [0, 1, 2]


def test_a_fan_closes_a_hole_and_has_the_area_that_its_border_says():
    points, faces = grid(6)
    (boundary,) = loops(border_edges(faces))
    made = fan(boundary[::-1], len(points))
    assert len(border_edges(np.concatenate([faces, made]))) == 0
    whole = np.concatenate([points, [[0.5, 0.5, 0.7]]])
    np.testing.assert_allclose(area_vector(whole, made), -area_vector(points, faces), atol=1e-12)
    flat = np.concatenate([points, [[0.5, 0.5, 0.0]]])
    assert area(flat, made) == pytest.approx(1.0)


@pytest.mark.parametrize("counts", [(10, 10), (30, 7), (5, 40)])
def test_a_strip_closes_the_gap_between_two_rings(counts):
    one, other = ring(counts[0], 2.0), ring(counts[1], 1.0)
    faces = strip(one, other, closed=True)
    assert len(faces) == sum(counts)
    inner = {frozenset(edge) for edge in border_edges(faces).tolist()}
    rings = [np.arange(counts[0]), counts[0] + np.arange(counts[1])]
    assert inner == {frozenset(pair) for each in rings for pair in walked(each)}
    places = np.concatenate([one, other])
    a, b, c = places[faces].transpose(1, 0, 2)
    heights = np.cross(b - a, c - a)[:, 2]
    assert (heights > -1e-12).all()
    outer, hole = (0.5 * count * np.sin(2 * np.pi / count) for count in counts)  # of radius 1
    assert 0.5 * heights.sum() == pytest.approx(4.0 * outer - hole)


@pytest.mark.parametrize("counts", [(2, 2), (9, 9), (20, 5), (1, 6)])
def test_an_open_strip_has_the_area_between_two_lines(counts):
    one, other = line(counts[0], 0.0), line(counts[1], 2.0)
    faces = strip(one, other, closed=False)
    assert len(faces) == sum(counts) - 2
    a, b, c = np.concatenate([one, other])[faces].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] >= 0.0).all()
    widths = [3.0 * (count > 1) for count in counts]
    assert area(np.concatenate([one, other]), faces) == pytest.approx(2.0 * sum(widths) / 2)
    assert len(some(faces)) == len({tuple(face) for face in faces.tolist()})

from __future__ import annotations

import numpy as np
import pytest

from meshmark.recovery import long_edges as refining
from meshmark.recovery.borders import border_edges
from meshmark.recovery.long_edges import split_long_edges
from tests.recovery.surfaces import area, area_vector, euler, off
from tests.shapes import sphere_with_a_spike

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
FACE = np.array([[0, 1, 2]])


def longest(points: np.ndarray, faces: np.ndarray) -> float:
    return float(np.linalg.norm(points[faces] - points[faces[:, [1, 2, 0]]], axis=2).max())


@pytest.mark.parametrize("limit", [0.15, 0.05])
def test_long_edges_are_split_and_the_surface_stays(limit):
    points, faces, _ = sphere_with_a_spike(16)
    fine, small = split_long_edges(points, faces, limit)
    assert longest(fine, small) <= limit
    assert not len(border_edges(small))
    assert euler(small) == 2
    assert off(points, faces, fine).max() < 1e-12
    assert area(fine, small) == pytest.approx(area(points, faces))
    assert np.array_equal(fine[: len(points)], points)


@pytest.mark.parametrize(("limit", "pieces"), [(1.5, 1), (1.2, 2), (0.8, 4)])
def test_a_triangle_has_as_many_pieces_as_sides_that_are_too_long(limit, pieces):
    """Sides 1, 1 and 1.41; after one round of halving none is longer than 0.71."""
    fine, small = split_long_edges(CORNERS, FACE, limit)
    assert len(small) == pieces
    np.testing.assert_allclose(area_vector(fine, small), [0, 0, 0.5], atol=1e-15)
    assert area(fine, small) == pytest.approx(0.5)


def test_of_two_long_sides_the_rest_is_cut_along_its_shorter_diagonal():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [3.6, 1, 0]])  # sides 4, 1.08 and 3.74
    fine, small = split_long_edges(points, FACE, 2.1)
    assert len(small) == 3
    assert longest(fine, small) <= 2.1
    assert area(fine, small) == pytest.approx(area(points, FACE))
    np.testing.assert_allclose(area_vector(fine, small), area_vector(points, FACE))


def test_what_is_short_enough_stays_as_it_is():
    points, faces, _ = sphere_with_a_spike(16)
    fine, small = split_long_edges(points, faces, (1.0 + 1e-9) * longest(points, faces))
    assert np.array_equal(fine, points)
    assert np.array_equal(small, faces)


def test_very_many_faces_are_not_split_further(monkeypatch):
    monkeypatch.setattr(refining, "MOST_FACES", 100)
    fine, small = split_long_edges(CORNERS, FACE, 1e-9)
    assert 100 < len(small) <= 400
    assert area(fine, small) == pytest.approx(0.5)

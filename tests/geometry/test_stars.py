"""Planes, creases, corners and borders are told apart by how far points can slide."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.stars import are_midpoints, stars_of
from meshmark.ownership.points.parameters import FREE
from tests.counting import some
from tests.low_poly import ball, box, joined, sheet, sides, subdivided, ticks, welded

SIZE = np.array([3.0, 2.0, 1.3])


def ways_to_slide(points, faces):
    """Return (p,): how many eigenvalues of each star are near 0."""
    return (np.linalg.eigvalsh(stars_of(points, faces).tensor) < FREE).sum(axis=1)


def sides_met(points):
    """Return (p,): on how many sides of the box from 0 to `SIZE` the points lie."""
    return (np.isclose(points, 0.0) | np.isclose(points, SIZE)).sum(axis=1)


def test_points_of_a_box_slide_in_two_directions_on_its_sides_in_one_on_its_edges_in_none_at_its_corners():
    points, faces = box((5, 4, 3), SIZE)
    slides = ways_to_slide(points, faces)
    np.testing.assert_array_equal(slides, 3 - sides_met(points))
    assert set(slides) == {0, 1, 2}


def test_the_directions_are_those_of_the_side_and_of_the_edge():
    points, faces = box((5, 4, 3), SIZE)
    tensor = stars_of(points, faces).tensor
    on = np.isclose(points, 0.0) | np.isclose(points, SIZE)
    inside = some(np.flatnonzero(on.sum(axis=1) == 1))
    for point in inside:
        expected = np.diag(on[point].astype(float))
        np.testing.assert_allclose(tensor[point], expected, atol=1e-12)
    for point in some(np.flatnonzero(on.sum(axis=1) == 2)):
        along = np.flatnonzero(~on[point])[0]
        np.testing.assert_allclose(tensor[point][along], 0.0, atol=1e-12)


def test_a_border_holds_its_points_across_but_not_along_it():
    points, faces = sheet(ticks(5, 1), ticks(4, 2))
    at = (np.isclose(points[:, :2], 0.0) | np.isclose(points[:, :2], 1.0)).sum(axis=1)
    np.testing.assert_array_equal(ways_to_slide(points, faces), 2 - at)
    tensor = stars_of(points, faces).tensor
    edge = np.flatnonzero((points[:, 0] == 0.0) & (at == 1))
    assert (tensor[some(edge), 0, 0] > 0.1).all()
    assert (tensor[edge, 1, 1] < 1e-12).all()


def test_a_fold_of_few_degrees_is_a_plane_and_one_of_many_is_a_crease():
    flat, faces = sheet(ticks(4, 1), np.array([0.0, 0.3, 0.5, 0.8, 1.0]))
    on_fold = (flat[:, 1] == 0.5) & (flat[:, 0] > 0.0) & (flat[:, 0] < 1.0)
    for degrees, slides in ((4.0, 2), (40.0, 1)):
        points = flat.copy()
        points[:, 2] = np.tan(np.radians(degrees)) * np.maximum(flat[:, 1] - 0.5, 0.0)
        assert (ways_to_slide(points, faces)[on_fold] == slides).all()
    assert on_fold.sum() == 3


@pytest.mark.parametrize("shape", [box((5, 4, 3), SIZE), ball(1)], ids=["box", "ball"])
def test_it_does_not_matter_which_way_faces_are_wound(shape):
    points, faces = shape
    tensor = stars_of(points, faces).tensor
    turned = faces.copy()
    turned[::3] = turned[::3, ::-1]
    np.testing.assert_allclose(stars_of(points, turned).tensor, tensor, atol=1e-12)
    rolled = np.roll(faces, 1, axis=1)[::-1]
    np.testing.assert_allclose(stars_of(points, rolled).tensor, tensor, atol=1e-12)


def test_it_does_not_matter_how_planes_are_split_into_triangles():
    one, other = (box((5, 4, 3), SIZE, other=way) for way in (False, True))
    np.testing.assert_array_equal(one[0], other[0])
    assert not np.array_equal(one[1], other[1])
    np.testing.assert_allclose(stars_of(*one).tensor, stars_of(*other).tensor, atol=1e-12)


def test_scale_and_place_change_nothing_and_a_turn_turns_the_tensor():
    points, faces = ball(1)
    stars, turn = stars_of(points, faces), rotation(b"s" * 32)
    moved = stars_of(1e-4 * points @ turn.T + 7.0, faces)
    np.testing.assert_allclose(moved.tensor, turn @ stars.tensor @ turn.T, atol=1e-9)
    np.testing.assert_allclose(moved.height, 1e-4 * stars.height, rtol=1e-9)


def test_the_height_is_the_smallest_of_the_triangles_around():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0], [-1, -1, 0], [9, 9, 9]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    thin = 3.0 / np.sqrt(17.0)  # double the area over the longest edge
    stars = stars_of(points, faces)
    np.testing.assert_allclose(stars.height, [thin, 12.0 / 5.0, thin, thin, 0.0])
    np.testing.assert_array_equal(stars.used, [True, True, True, True, False])


def test_a_sliver_has_no_say():
    points, faces = sheet(ticks(3, 1), ticks(3, 2))
    before = stars_of(points, faces)
    inner = np.flatnonzero((np.abs(points[:, :2] - 0.5) < 0.45).all(axis=1))
    low, high = some(inner, 2)[:2]
    # A spike of no width, upright where the sheet is flat.
    more = np.concatenate([points, (points[low] + points[high])[None] / 2.0 + 1e-13])
    stars = stars_of(more, np.concatenate([faces, [[low, high, len(points)]]]))
    np.testing.assert_allclose(stars.tensor[inner], before.tensor[inner], atol=1e-9)
    np.testing.assert_array_equal(stars.height[inner], before.height[inner])
    assert not stars.used[-1]


def test_a_surface_without_faces_has_no_stars():
    stars = stars_of(np.eye(3), np.zeros((0, 3), np.int64))
    assert not stars.used.any()
    assert not stars.tensor.any()
    assert not stars.height.any()


def test_sides_that_are_not_joined_slide_like_sheets():
    points, faces = joined(sides((4, 3, 3)))
    apart = ways_to_slide(points, faces)
    whole, _ = welded((points, faces))
    assert len(whole) < len(points)
    inner = ((points > 1e-9) & (points < 1.0 - 1e-9)).sum(axis=1)
    np.testing.assert_array_equal(apart, inner)


def test_middles_of_edges_are_what_a_subdivision_added():
    points, faces = ball(1)
    more, split = subdivided((points, faces))
    edges = unique_edges(split)
    found = are_midpoints(more, edges, 1e-9)
    np.testing.assert_array_equal(found, np.arange(len(more)) >= len(points))
    assert not are_midpoints(points, unique_edges(faces), 1e-9).any()


def test_a_point_beside_the_middle_by_more_than_the_tolerance_is_none():
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [1.0, 1.0, 0.0]])
    edges = np.array([[0, 1], [1, 2], [0, 3], [1, 3], [2, 3]])
    np.testing.assert_array_equal(are_midpoints(points, edges, 1e-6), [False, True, False, False])
    points[1, 2] = 1e-4
    assert not are_midpoints(points, edges, 0.9e-4).any()
    assert are_midpoints(points, edges, 1.1e-4)[1]

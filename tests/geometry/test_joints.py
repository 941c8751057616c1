"""Near points and points on the edges of others follow, so that nothing cracks."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.joints import NEAR, joints_of
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from tests.counting import some
from tests.low_poly import ball, box, joined, sheet, sides, table, ticks


def joints(points, faces):
    """Return the joints of a surface as a plain matrix."""
    surface = surface_of(Mesh(points, faces))
    np.testing.assert_array_equal(surface.points, points + 0.0)
    return joints_of(surface).toarray()


def motion_of(points):
    return np.random.default_rng(3).normal(size=points.shape)


def strip(cuts, low):
    """Return a sheet between y = low and low + 1, cut like this along x."""
    points, faces = sheet(np.asarray(cuts, dtype=float), np.array([0.0, 1.0]))
    return points + np.array([0.0, low, 0.0]), faces


def seam(points, y=1.0):
    return np.flatnonzero(np.isclose(points[:, 1], y))


def test_where_points_are_apart_and_edges_shared_each_moves_by_itself():
    for points, faces in (ball(1), box((4, 3, 2), (3.0, 2.0, 1.0)), table()):
        np.testing.assert_array_equal(joints(points, faces), np.eye(len(points)))


def test_near_points_follow_the_first_of_them():
    points, faces = joined(sides((3, 2, 2)))
    random = np.random.default_rng(1)
    nudged = points + 0.3 * NEAR * random.uniform(-1.0, 1.0, points.shape)
    rows = joints(nudged, faces)
    places = np.unique(np.round(points, 6), axis=0)
    leaders = np.flatnonzero(rows.sum(axis=0))
    assert len(leaders) == len(places) < len(points)
    assert set(np.unique(rows)) == {0.0, 1.0}
    np.testing.assert_array_equal(rows.argmax(axis=1)[leaders], leaders)
    np.testing.assert_allclose(points[rows.argmax(axis=1)], points, atol=1e-9)
    assert (rows.argmax(axis=1) <= np.arange(len(points))).all()


def test_points_further_apart_than_the_tolerance_are_two_places():
    points, faces = joined([strip([0.0, 1.0], 0.0), strip([0.0, 1.0], 1.0 + 1e-4)])
    assert 1.5 * NEAR * np.linalg.norm(np.ptp(points, axis=0)) < 1e-4
    np.testing.assert_array_equal(joints(points, faces), np.eye(len(points)))


def test_a_point_inside_an_edge_follows_its_ends_by_where_it_lies():
    # The upper strip has points at a quarter and 0.7 of the one edge of the lower.
    lower, upper = strip([0.0, 1.0], 0.0), strip([0.0, 0.25, 0.7, 1.0], 1.0)
    points, faces = joined([lower, upper])
    points[4:] += 1e-9  # near, but no single point
    rows = joints(points, faces)
    moved = rows @ motion_of(points)
    ends = {x: int(np.flatnonzero((points[:4] == [x, 1.0, 0.0]).all(axis=1))[0]) for x in (0.0, 1.0)}
    for share in (0.25, 0.7):
        inside = np.flatnonzero(np.isclose(points[:, 0], share) & np.isclose(points[:, 1], 1.0))
        assert len(inside) == 1
        expected = (1.0 - share) * moved[ends[0.0]] + share * moved[ends[1.0]]
        np.testing.assert_allclose(moved[inside[0]], expected, atol=1e-7)
    alone = np.flatnonzero(~np.isclose(points[:, 1], 1.0))
    np.testing.assert_array_equal(rows[some(alone)], np.eye(len(points))[alone])


def test_edges_that_overlap_stay_on_one_line():
    # Between 0 and 1 the two borders share no points: 0.4 lies on an edge to 0.7, 0.7 on one from 0.4.
    points, faces = joined([strip([0.0, 0.4, 1.0], 0.0), strip([0.0, 0.7, 1.0], 1.0)])
    points[6:] += 1e-9
    rows = joints(points, faces)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, atol=1e-6)
    assert rows.min() >= 0.0
    moved = (rows @ motion_of(points))[np.isclose(points[:, 1], 1.0)]
    share = points[np.isclose(points[:, 1], 1.0), :1]
    first, last = (moved[np.argmin(np.abs(share[:, 0] - end))] for end in (0.0, 1.0))
    np.testing.assert_allclose(moved, (1.0 - share) * first + share * last, atol=1e-6)
    loose = joined([strip([0.0, 0.4, 1.0], 0.0), strip([0.0, 0.7, 1.0], 2.0)])
    np.testing.assert_array_equal(joints(*loose), np.eye(len(points)))


@pytest.mark.parametrize("count", [5, 20, 60])
def test_borders_along_one_line_that_are_cut_differently_stay_on_it(count):
    # Ends that nearly meet follow each other many times over.
    points, faces = joined([strip(ticks(count, 1), 0.0), strip(ticks(count, 2), 1.0)])
    points[2 * count + 2 :] += 1e-9
    rows, at = joints(points, faces), seam(points)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, atol=1e-12)
    leads = rows.any(axis=0)
    np.testing.assert_array_equal(leads[at], np.isin(points[at, 0], [0.0, 1.0]))
    moved, share = rows @ motion_of(points), points[at, :1]
    first, last = (moved[at[np.argmin(np.abs(share[:, 0] - end))]] for end in (0.0, 1.0))
    np.testing.assert_allclose(moved[at], (1.0 - share) * first + share * last, atol=1e-6)


@pytest.mark.parametrize("order", [1, -1])
def test_several_points_in_one_edge_all_follow_its_ends(order):
    cuts = ticks(9, 4)
    parts = [strip([0.0, 1.0], 0.0), strip(cuts, 1.0)][::order]
    points, faces = joined(parts)
    points[len(parts[0][0]) :] += 1e-9
    rows = joints(points, faces)
    at = seam(points)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, atol=1e-12)
    moved = rows @ motion_of(points)
    first, last = (moved[at[np.argmin(np.abs(points[at, 0] - end))]] for end in (0.0, 1.0))
    share = points[at, :1]
    np.testing.assert_allclose(moved[at], (1.0 - share) * first + share * last, atol=1e-6)


def test_what_follows_follows_what_leads_and_moves_no_further():
    points, faces = joined([strip([0.0, 0.5, 1.0], 0.0), strip(ticks(4, 2), 1.0), strip(ticks(7, 3), 2.0)])
    points[6:16] += 1e-9
    points[16:] += 2e-9
    rows = joints(points, faces)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(rows @ rows, rows, atol=1e-6)
    assert 0 < (rows.diagonal() != 1.0).sum() < len(points)
    assert np.abs(rows @ motion_of(points)).max() <= np.abs(motion_of(points)).max() + 1e-9

from __future__ import annotations

import numpy as np
import pytest

from meshmark.recovery.borders import border_edges
from meshmark.recovery.hole_filling import fill_holes
from meshmark.recovery.simplify import simplify
from tests.recovery.surfaces import euler, off
from tests.shapes import pebble


@pytest.fixture(scope="module")
def whole():
    return pebble(48)


@pytest.fixture(scope="module")
def mini(whole):
    return simplify(*whole, 300)


def without(surface, place: np.ndarray, radius: float):
    """Return points and the faces that do not touch a ball, and which points are on the boundary of the hole."""
    points, faces = surface
    hit = np.linalg.norm(points - place, axis=1) < radius
    left = faces[~hit[faces].any(axis=1)]
    boundary = np.zeros(len(points), bool)
    boundary[border_edges(left)] = True
    return points, left, boundary


@pytest.mark.parametrize("radius", [0.25, 0.5, 0.9])
@pytest.mark.parametrize("seed", [1, 400, 900])
def test_a_hole_is_closed_as_the_miniature_has_it(whole, mini, radius, seed):
    points, left, boundary = without(whole, whole[0][seed], radius)
    filled = fill_holes(points, left, boundary, boundary, mini)
    assert not len(border_edges(filled.faces))
    assert euler(filled.faces) == 2
    assert np.array_equal(filled.points[: len(points)], points)
    assert np.array_equal(filled.faces[: len(left)], left)
    new = filled.points[len(points) :]
    assert len(new)
    assert off(*whole, new).max() < 0.03
    used = np.zeros(len(filled.points), bool)
    used[filled.faces] = True
    assert used[len(points) :].all(), "no points that nothing uses"


def test_two_holes_are_closed_each_by_its_own_part(whole, mini):
    points, left, _ = without(whole, whole[0][whole[0][:, 0].argmax()], 0.5)
    points, left, boundary = without((points, left), whole[0][whole[0][:, 0].argmin()], 0.5)
    filled = fill_holes(points, left, boundary, boundary, mini)
    assert not len(border_edges(filled.faces))
    assert euler(filled.faces) == 2
    assert off(*whole, filled.points[len(points) :]).max() < 0.03


def test_a_hole_whose_rim_is_not_touched_stays(whole, mini):
    points, left, boundary = without(whole, whole[0][400], 0.5)
    filled = fill_holes(points, left, np.zeros(len(points), bool), boundary, mini)
    assert filled.points is points
    assert filled.faces is left


def test_a_hole_that_the_miniature_has_too_stays(whole):
    points, left, boundary = without(whole, whole[0][400], 0.5)
    used = np.unique(left)
    own = simplify(points[used], np.searchsorted(used, left), 400)
    filled = fill_holes(points, left, boundary, boundary, own)
    assert np.array_equal(filled.faces, left)


@pytest.mark.parametrize(("is_opened", "open_edges"), [(True, 0), (False, 3)])
def test_a_hole_too_small_for_the_miniature_is_closed_by_a_fan_if_opened(whole, mini, is_opened, open_edges):
    points, faces = whole
    left = np.delete(faces, 700, axis=0)
    boundary = np.zeros(len(points), bool)
    boundary[faces[700]] = True
    filled = fill_holes(points, left, boundary, boundary & is_opened, mini)
    assert len(border_edges(filled.faces)) == open_edges
    assert len(filled.faces) == len(left) + 3 * is_opened
    assert len(filled.points) == len(points) + is_opened
    middle = points[faces[700]].mean(axis=0)
    np.testing.assert_allclose(filled.points[len(points) :], np.tile(middle, (int(is_opened), 1)))

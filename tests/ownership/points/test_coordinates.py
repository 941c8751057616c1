"""Which coordinates carry, and how points move whose coordinates are set or held."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.geometry.stars import stars_of
from meshmark.ownership.points.coordinates import chosen_coordinates, held
from meshmark.ownership.points.parameters import FREE, MODES, SLIDING
from tests.counting import some
from tests.low_poly import ball, box

TURN = rotation(b"c" * 32)


def turned_box():
    """Return the tensors of a box that lies askew, and in how many directions each point slides."""
    points, faces = box((5, 4, 3), (3.0, 2.0, 1.3))
    tensor = stars_of(points @ TURN.T, faces).tensor
    return tensor, (np.linalg.eigvalsh(tensor) < FREE).sum(axis=1)


def firsts(points):
    """Return which coordinate is preferred at each of so many points."""
    return np.random.default_rng(9).integers(3, size=len(points))


def random_ease(count=50):
    root = np.random.default_rng(1).normal(size=(count, 3, 3))
    return root @ root.transpose(0, 2, 1) + 0.01 * np.eye(3)


@pytest.mark.parametrize("mode", MODES)
def test_planes_creases_and_corners_carry_as_many_as_the_mode_says(mode):
    tensor, slides = turned_box()
    (chosen,) = chosen_coordinates(tensor, [mode], firsts(tensor))
    for free, wanted in zip((2, 1, 0), mode, strict=True):
        assert (chosen[some(np.flatnonzero(slides == free))].sum(axis=1) == wanted).all()


def test_every_mode_carries_what_the_one_before_does():
    tensor, _ = turned_box()
    for one, other in some(pairwise(MODES), 3):
        less, more = chosen_coordinates(tensor, [one, other], firsts(tensor))
        assert (more[less]).all()
        assert more.sum() > less.sum()


def test_on_a_plane_along_the_axes_the_two_in_it_carry():
    points, faces = box((5, 4, 3), (3.0, 2.0, 1.3))
    (chosen,) = chosen_coordinates(stars_of(points, faces).tensor, MODES[:1], firsts(points))
    fixed = np.isclose(points, 0.0) | np.isclose(points, [3.0, 2.0, 1.3])
    flat = some(np.flatnonzero(fixed.sum(axis=1) == 1))
    np.testing.assert_array_equal(chosen[flat], ~fixed[flat])
    crease = some(np.flatnonzero(fixed.sum(axis=1) == 2))
    np.testing.assert_array_equal(chosen[crease], ~fixed[crease])


def test_the_key_says_which_coordinate_of_a_corner_of_a_box_carries():
    points, faces = box((1, 1, 1), (3.0, 2.0, 1.3))
    tensor, first = stars_of(points, faces).tensor, firsts(points)
    one, two = chosen_coordinates(tensor, [(0, 0, 1), (0, 0, 2)], first)
    assert len(np.unique(first)) == 3
    np.testing.assert_array_equal(one.argmax(axis=1), first)
    assert (one.sum(axis=1) == 1).all()
    np.testing.assert_array_equal((two & ~one).argmax(axis=1), (first + 1) % 3)


def test_a_coordinate_that_moves_more_cheaply_carries_whatever_is_preferred():
    tensor = np.tile(np.diag([1.0, 0.5, 0.9]), (3, 1, 1))
    (chosen,) = chosen_coordinates(tensor, [(0, 0, 1)], np.arange(3))
    np.testing.assert_array_equal(chosen.argmax(axis=1), [1, 1, 1])


def test_the_choice_does_not_hang_on_rounding():
    points, faces = box((5, 4, 3), (3.0, 2.0, 1.3))
    for shape in ((points, faces), (points @ TURN.T, faces), ball(1)):
        rough = np.random.default_rng(2).normal(size=shape[0].shape) * 1e-7
        tensors = [stars_of(places, shape[1]).tensor for places in (shape[0], shape[0] + rough)]
        for mode in some(MODES):
            one, other = (chosen_coordinates(tensor, [mode], firsts(tensor))[0] for tensor in tensors)
            np.testing.assert_array_equal(one, other)


def test_set_coordinates_are_followed_exactly():
    ease, random = random_ease(), np.random.default_rng(3)
    carried = random.random((50, 3)) < 0.6
    change = random.normal(size=(50, 3))
    follow, _ = held(ease, carried)
    motion = np.einsum("pij,pj->pi", follow, change)
    np.testing.assert_allclose(motion[carried], change[carried], atol=1e-9)
    assert (follow.transpose(0, 2, 1)[~carried] == 0.0).all()
    assert not carried.all()


def test_held_motions_leave_the_carried_coordinates():
    ease, random = random_ease(), np.random.default_rng(4)
    carried = random.random((50, 3)) < 0.5
    _, rest = held(ease, carried)
    motion = np.einsum("pij,pj->pi", rest, random.normal(size=(50, 3)))
    assert np.abs(motion[carried]).max() < 1e-9
    np.testing.assert_allclose(rest, rest.transpose(0, 2, 1), atol=1e-9)
    assert np.linalg.eigvalsh(rest).min() > -1e-9
    np.testing.assert_array_equal(rest[carried.all(axis=1)], 0.0)
    np.testing.assert_array_equal(rest[~carried.any(axis=1)], ease[~carried.any(axis=1)])


def test_no_motion_with_these_coordinates_is_cheaper():
    ease, random = random_ease(), np.random.default_rng(5)
    cost = np.linalg.inv(ease)
    carried = np.tile([[True, False, False], [False, True, True]], (25, 1))
    follow, rest = held(ease, carried)
    motion = np.einsum("pij,pj->pi", follow, random.normal(size=(50, 3)))
    price = np.einsum("pi,pij,pj->p", motion, cost, motion)
    for _ in range(20):
        other = motion + np.einsum("pij,pj->pi", rest, random.normal(size=(50, 3)))
        assert (np.einsum("pi,pij,pj->p", other, cost, other) > price).all()


def test_on_a_plane_a_set_coordinate_moves_the_point_within_it():
    tensor, slides = turned_box()
    (chosen,) = chosen_coordinates(tensor, MODES[:1], firsts(tensor))
    follow, _ = held(np.linalg.inv(tensor + SLIDING * np.eye(3)), chosen)
    flat = np.flatnonzero(slides == 2)
    normal = np.linalg.eigh(tensor[some(flat)])[1][:, :, 2]
    change = np.random.default_rng(6).normal(size=(len(flat), 3))
    motion = np.einsum("pij,pj->pi", follow[flat], change)
    off = np.abs(np.einsum("pi,pi->p", motion, normal))
    assert off.max() < 0.02 * np.linalg.norm(motion, axis=1).max()

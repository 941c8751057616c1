from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.errors import InputError
from meshmark.geometry.frame import canonical_frame, frame_alternatives, signed_axes, surface_moments
from tests.counting import some
from tests.shapes import pebble


def split(points, faces):
    """Midpoint subdivision without shared midpoints: the same surface by other triangles."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.concatenate(
        [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def test_moments_of_a_square_plate():
    points = np.array([[0, 0, 5], [2, 0, 5], [2, 2, 5], [0, 2, 5]], dtype=float)
    area, centre, second = surface_moments(points, np.array([[0, 1, 2], [0, 2, 3]]))
    assert area == pytest.approx(4.0)
    np.testing.assert_allclose(centre, [1, 1, 5])
    np.testing.assert_allclose(second, np.diag([1 / 3, 1 / 3, 0]), atol=1e-15)  # width^2 / 12


def test_signed_axes_are_rotations_that_only_the_least_skew_axis_may_spoil():
    random = np.random.default_rng(5)
    axes = np.linalg.qr(random.normal(size=(200, 3, 3)))[0]
    third = random.normal(size=(200, 3))
    signed = signed_axes(axes, third)
    np.testing.assert_allclose(np.linalg.det(signed), 1.0)
    turned = (signed * axes).sum(axis=1)  # 1 or -1 for each axis
    np.testing.assert_allclose(np.abs(turned), 1.0)
    backward = (third * turned < 0.0).nonzero()
    assert 50 < len(backward[0]) < 150
    np.testing.assert_array_equal(backward[1], np.abs(third).argmin(axis=1)[backward[0]])
    for one, moments, expected in some(zip(axes, third, signed, strict=True)):
        np.testing.assert_array_equal(signed_axes(one, moments), expected)


def test_moments_belong_to_the_surface_not_to_its_triangles():
    points, faces = pebble(24)
    for one, other in some(
        zip(surface_moments(points, faces), surface_moments(*split(points, faces)), strict=True)
    ):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-14)


def test_canonical_coordinates_do_not_see_a_similarity_transform():
    points, faces = pebble(24)
    moved = 17.3 * points @ rotation(b"turn" * 8).T + [4.0, -5.0, 600.0]
    frame, other = canonical_frame(points, faces), canonical_frame(moved, faces)
    np.testing.assert_allclose(frame.to_canonical(points), other.to_canonical(moved), atol=1e-11)
    np.testing.assert_allclose(other.to_scene(other.to_canonical(moved)), moved, rtol=1e-12)
    assert other.scale == pytest.approx(17.3 * frame.scale)
    assert other.area == pytest.approx(frame.area)


def test_canonical_coordinates_are_centred_scaled_and_turned():
    points, faces = pebble(24)
    frame = canonical_frame(points, faces)
    _, centre, second = surface_moments(frame.to_canonical(points), faces)
    np.testing.assert_allclose(centre, 0.0, atol=1e-14)
    np.testing.assert_allclose(second, np.diag(frame.moments), atol=1e-14)
    assert frame.moments.sum() == pytest.approx(1.0)
    assert (np.diff(frame.moments) <= 0).all()
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)


def test_alternatives_are_the_four_proper_sign_patterns_and_exchanges_only_where_moments_are_close():
    points, faces = pebble(24)
    frame = canonical_frame(points, faces)
    turns = [frame.axes.T @ other.axes for other in frame_alternatives(frame)]
    assert len(turns) == 4
    for turn in some(turns):
        np.testing.assert_allclose(np.abs(turn), np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
    ring = canonical_frame(points * [1.0, 1.0, 1.0], faces)
    sphere = replace(ring, moments=np.array([0.34, 0.33, 0.33]), skewness=np.zeros(3))
    wide = [sphere.axes.T @ other.axes for other in frame_alternatives(sphere, exchange=True)]
    assert len({tuple(np.round(turn, 6).ravel()) for turn in wide}) == 24  # all rotations of a cube


def test_no_area_is_refused_in_one_sentence():
    with pytest.raises(InputError, match="zero area"):
        canonical_frame(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))


def test_skewness_is_the_normalised_third_moment_and_knows_no_unit():
    points, faces = pebble(48)
    frame = canonical_frame(points, faces)
    canonical = frame.to_canonical(points)
    corners = canonical[faces]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    middles = corners.mean(axis=1)
    third = (areas[:, None] * middles**3).sum(axis=0) / areas.sum()
    np.testing.assert_allclose(frame.skewness, np.abs(third) / frame.moments**1.5, atol=0.01)
    assert frame.skewness.max() > 0.1
    np.testing.assert_allclose(
        canonical_frame(37.0 * points + 5.0, faces).skewness, frame.skewness, rtol=1e-6
    )


def test_surely_skew_axes_are_not_turned_round():
    points, faces = pebble(48)
    frame = canonical_frame(points, faces)
    (only,) = frame_alternatives(frame, surely_skew=1e-9)
    np.testing.assert_array_equal(only.axes, frame.axes)
    assert len(list(frame_alternatives(frame, surely_skew=10.0))) == 4

"""The moments that make the canonical frame, and how they change with the points."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.frame import canonical_frame, surface_moments
from meshmark.ownership.points.frame_moments import frame_moments
from tests.low_poly import ball, box, prism

SHAPES = {"box": box((3, 2, 2), (3.0, 2.0, 1.3)), "ball": ball(1), "prism": prism(7, 3, 2.0)}
SHAPES["unused"] = np.concatenate([SHAPES["ball"][0], [[5.0, 5.0, 5.0]]]), SHAPES["ball"][1]
INDICES = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])


@pytest.mark.parametrize("name", SHAPES)
def test_the_values_are_those_that_the_frame_is_made_of(name):
    points, faces = SHAPES[name]
    values, _ = frame_moments(points, faces)
    _, centre, second = surface_moments(points, faces)
    np.testing.assert_allclose(values[:3], centre, atol=1e-12)
    np.testing.assert_allclose(values[3:], second[INDICES], atol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_in_canonical_coordinates_they_are_the_frames_moments(name):
    points, faces = SHAPES[name]
    frame = canonical_frame(points, faces)
    values, _ = frame_moments(frame.to_canonical(points), faces)
    np.testing.assert_allclose(values, [0, 0, 0, *frame.moments, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("with_area", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_the_gradient_is_that_of_finite_differences(name, with_area):
    points, faces = SHAPES[name]
    _, gradient = frame_moments(points, faces, with_area=with_area)
    assert gradient.shape == (9 + with_area, len(points), 3)
    random = np.random.default_rng(1)
    for _ in range(5):
        motion = random.normal(size=points.shape)
        ends = [
            frame_moments(points + sign * 1e-5 * motion, faces, with_area=with_area)[0]
            for sign in (1.0, -1.0)
        ]
        told = np.einsum("qpi,pi->q", gradient, motion)
        np.testing.assert_allclose(told, (ends[0] - ends[1]) / 2e-5, rtol=1e-6, atol=1e-8)


def test_the_last_value_is_the_logarithm_of_the_area():
    points, faces = SHAPES["box"]
    values, _ = frame_moments(points, faces, with_area=True)
    assert values[9] == pytest.approx(np.log(2.0 * (3.0 * 2.0 + 3.0 * 1.3 + 2.0 * 1.3)), abs=1e-12)


def test_a_shift_moves_the_centre_alone_and_a_point_of_no_face_nothing():
    points, faces = SHAPES["unused"]
    _, gradient = frame_moments(points, faces)
    np.testing.assert_allclose(gradient.sum(axis=1), np.eye(9)[:, :3], atol=1e-12)
    np.testing.assert_array_equal(gradient[:, -1], 0.0)


def test_faces_without_area_weigh_nothing():
    points, faces = SHAPES["ball"]
    values, gradient = frame_moments(points, faces)
    spike = np.concatenate([faces, [[3, 4, 4]]])
    again, slope = frame_moments(points, spike)
    np.testing.assert_allclose(again, values, atol=1e-15)
    np.testing.assert_allclose(slope, gradient, atol=1e-15)

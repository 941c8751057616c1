"""A planar cut is found where one was made, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.cut import find_cut
from tests.shapes import pebble, sphere_with_a_spike


def crop(points, faces, normal, level):
    keep = points @ normal < level
    return points, faces[keep[faces].all(axis=1)]


@pytest.mark.parametrize("seed", range(6))
def test_the_plane_of_a_crop_is_found(seed):
    points, faces = pebble(40)
    normal = np.random.default_rng(seed).normal(size=3)
    normal /= np.linalg.norm(normal)
    level = float(np.quantile(points @ normal, 0.8))
    cut = find_cut(*crop(points, faces, normal, level))
    assert cut is not None
    edge = np.median(np.linalg.norm(points[faces[:, 0]] - points[faces[:, 1]], axis=1))
    assert np.degrees(np.arccos(min(1.0, float(cut.normal @ normal)))) < 5.0
    assert level - 2.0 * edge < cut.centre @ normal < level


def test_the_border_of_a_half_ball_is_measured():
    """A sphere cut through its middle: border 2 pi, area pi, spread 1/2 in the plane."""
    points, faces, _ = sphere_with_a_spike(120)
    points = points / np.linalg.norm(points, axis=1)[:, None]
    cut = find_cut(*crop(points, faces, np.array([0.0, 0.0, 1.0]), 0.0))
    assert cut is not None
    assert cut.area == pytest.approx(np.pi, rel=0.05)
    assert cut.length == pytest.approx(2.0 * np.pi, rel=0.45)  # a zigzag is longer
    np.testing.assert_allclose(cut.spread, np.diag([0.5, 0.5, 0.0]), atol=0.04)
    assert cut.radius >= 1.0 - 0.05


def test_a_closed_surface_has_no_cut():
    assert find_cut(*pebble(30)) is None


def test_points_without_faces_do_not_count():
    """A crop may leave the vertices of what is gone."""
    points, faces = crop(*pebble(40), np.array([0.0, 0.6, 0.8]), 0.5)
    used = np.unique(faces)
    number = np.zeros(len(points), np.int64)
    number[used] = np.arange(len(used))
    one, other = find_cut(points, faces), find_cut(points[used], number[faces])
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(one.centre, other.centre)


def test_the_same_cut_every_time():
    points, faces = pebble(30)
    part = crop(points, faces, np.array([0.6, 0.0, 0.8]), 0.4)
    one, other = find_cut(*part), find_cut(*part)
    assert one is not None
    assert other is not None
    np.testing.assert_array_equal(one.normal, other.normal)
    np.testing.assert_array_equal(one.centre, other.centre)


def plates(count, rng):
    """Squares that float about a ball of radius 2, each along its own tangent plane."""
    points, faces = [], []
    for i in range(count):
        out = rng.normal(size=3)
        out /= np.linalg.norm(out)
        one, other = np.linalg.svd(out[None])[2][1:]
        points.append(2.0 * out + 0.2 * np.array([one + other, one - other, -one - other, other - one]))
        faces.append(4 * i + np.array([[0, 1, 2], [0, 2, 3]]))
    return np.concatenate(points), np.concatenate(faces)


def test_plates_are_no_cut():
    """All their edges are open and lie in planes with nothing beyond, but they end within these planes."""
    assert find_cut(*plates(6, np.random.default_rng(4))) is None


def test_a_cut_is_found_among_plates():
    points, faces = pebble(40)
    normal = np.array([0.0, 0.6, 0.8])
    level = float(np.quantile(points @ normal, 0.8))
    soup, squares = plates(6, np.random.default_rng(4))
    below = soup[:, None].reshape(-1, 4, 3) @ normal < level
    squares = squares[np.repeat(below.all(axis=1), 2)]
    assert len(squares) >= 4
    part = crop(points, faces, normal, level)[1]
    cut = find_cut(np.concatenate([points, soup]), np.concatenate([part, squares + len(points)]))
    assert cut is not None
    assert np.degrees(np.arccos(min(1.0, float(cut.normal @ normal)))) < 5.0

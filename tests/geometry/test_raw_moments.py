"""Raw moments against sums over many small pieces, and their adding up."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.raw_moments import raw_moments
from tests.shapes import pebble


def split(points, faces, times):
    """Divide every face in four, so many times, without moving the surface."""
    corners = points[faces]
    for _ in range(times):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners = np.concatenate(
            [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    return corners


def test_moments_are_those_of_many_small_pieces():
    points, faces = pebble(16)
    points = points + np.array([0.3, -0.2, 0.5])
    exact = raw_moments(points, faces)
    corners = split(points, faces, 4)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    x = corners.mean(axis=1)
    np.testing.assert_allclose(exact.area, areas.sum(), rtol=1e-12)
    np.testing.assert_allclose(exact.first, areas @ x, rtol=1e-12)
    np.testing.assert_allclose(exact.second, np.einsum("f,fi,fj->ij", areas, x, x), atol=2e-3)
    np.testing.assert_allclose(exact.third, np.einsum("f,fi,fj,fk->ijk", areas, x, x, x), atol=4e-3)


def test_moments_of_parts_add_up():
    points, faces = pebble(16)
    whole, one, other = (raw_moments(points, part) for part in (faces, faces[:37], faces[37:]))
    for name in ("area", "first", "second", "third"):
        np.testing.assert_allclose(
            getattr(whole, name), getattr(one, name) + getattr(other, name), atol=1e-12
        )


def test_a_face_does_not_depend_on_the_order_of_its_corners():
    points, faces = pebble(16)
    np.testing.assert_allclose(
        raw_moments(points, faces).third, raw_moments(points, faces[:, [1, 2, 0]]).third
    )

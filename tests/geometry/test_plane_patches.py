"""Plane patches are found whatever their triangles are, and how far their points are off planes is measured."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.geometry import plane_patches
from meshmark.geometry.plane_patches import PlanePatches
from tests.low_poly import ball, box, frustum, prism
from tests.shapes import pebble


def test_the_sides_of_a_box_are_six_patches_that_cover_it():
    points, faces = box((6, 5, 4), (3.0, 2.0, 1.3))
    for placed in (points, 40.0 * points @ rotation(b"r" * 32).T + 7.0):
        found = PlanePatches.of(placed, faces)
        assert len(np.unique(found.patch)) == 6
        assert found.points.all()
        assert found.share == pytest.approx(1.0)
        assert found.off_plane(placed) < 1e-9 * np.ptp(placed)


def test_edges_belong_to_both_sides_and_corners_to_three():
    points, faces = box((2, 2, 2), (1.0, 1.0, 1.0))
    found = PlanePatches.of(points, faces)
    times = np.bincount(found.point, minlength=len(points))
    assert sorted(times.tolist()) == [1] * 6 + [2] * 12 + [3] * 8


@pytest.mark.parametrize("shape", [ball(2), pebble(24)])
def test_a_round_shape_has_none(shape):
    found = PlanePatches.of(*shape)
    assert (found.share, found.points.any(), len(found.point)) == (0.0, False, 0)
    assert found.off_plane(shape[0] + 1.0) == 0.0


def test_flat_ends_of_a_round_column_and_slanted_walls_count():
    column = PlanePatches.of(*prism(16, 6, 3.0))
    assert len(np.unique(column.patch)) == 18
    assert PlanePatches.of(*frustum()).share == pytest.approx(1.0)


def test_the_distance_is_that_of_the_fitted_planes():
    points, faces = box((6, 5, 4), (3.0, 2.0, 1.3))
    found = PlanePatches.of(points, faces)
    side = np.flatnonzero(points[:, 2] == 1.3)
    inner = side[np.bincount(found.point)[side] == 1]
    assert found.off_plane(points * [1.1, 0.9, 1.2] + [0.3, 0.0, 0.0]) < 1e-12  # stretched planes are plane
    moved = points.copy()
    moved[inner, 2] += 0.01 * np.where(np.arange(len(inner)) % 2, 1.0, -1.0)
    expected = 0.01 * np.sqrt(len(inner) / len(found.point))
    assert found.off_plane(moved) == pytest.approx(expected, rel=0.05)


def test_nothing_has_no_planes():
    found = PlanePatches.of(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    assert (found.share, found.off_plane(np.zeros((0, 3)))) == (0.0, 0.0)


def test_on_a_mesh_of_millions_of_points_tiny_patches_say_nothing(monkeypatch):
    points, faces = box((6, 5, 4), (3.0, 2.0, 1.3))
    both = np.concatenate([points, 1e-4 * points + 1.0]), np.concatenate([faces, faces + len(points)])
    assert len(np.unique(PlanePatches.of(*both).patch)) == 12
    monkeypatch.setattr(plane_patches, "_FINE", 0)
    found = PlanePatches.of(*both)
    assert len(np.unique(found.patch)) == 6
    assert not found.points[len(points) :].any()

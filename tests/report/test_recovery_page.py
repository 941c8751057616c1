"""What a recovery restored is told from what is as it was signed off; distances are drawn with their bar."""

from __future__ import annotations

import numpy as np
from PIL import Image

from meshmark.mesh import Mesh
from meshmark.report.displacement_picture import displacement_picture, distances
from meshmark.report.recovery_page import restored_vertices
from tests.shapes import pebble


def test_vertices_that_moved_or_are_new_are_restored_whatever_their_order():
    points, faces = pebble(20)
    suspect = Mesh(points, faces)
    moved = points.copy()
    moved[5] += 0.1
    more = np.concatenate([moved[::-1], [[9.0, 9.0, 9.0]]])
    restored = restored_vertices(suspect, Mesh(more, faces))
    expected = np.zeros(len(more), bool)
    expected[[len(points) - 1 - 5, len(points)]] = True
    np.testing.assert_array_equal(restored, expected)
    assert not restored_vertices(suspect, suspect).any()


def test_distances_are_of_vertices_where_they_match_and_else_of_the_surface():
    points, faces = pebble(20)
    first, slid = Mesh(points, faces), np.roll(points, 1, axis=0)
    np.testing.assert_allclose(distances(first, Mesh(slid, faces)), np.linalg.norm(slid - points, axis=1))
    assert distances(first, Mesh(slid, faces[::-1].copy())).max() < 1e-12


def test_the_picture_has_its_bar_and_the_darkest_place_is_the_farthest(tmp_path):
    points, faces = pebble(24)
    pushed = points.copy()
    pushed[points[:, 2] > np.quantile(points[:, 2], 0.9)] *= 1.1
    displacement_picture(Mesh(points, faces), Mesh(pushed, faces), tmp_path / "d.png", size=150)
    picture = np.asarray(Image.open(tmp_path / "d.png")).astype(int)
    assert picture.shape == (150 + 2 * 40, 450, 3)
    red = (picture[..., 0] - picture[..., 2]) > 60
    assert red[:150, 300:].sum() > 50
    assert red[:150, :300].sum() == 0
    assert red[190:].sum() > 100, "the bar"
    displacement_picture(Mesh(points, faces), Mesh(points, faces), tmp_path / "same.png", size=150)
    same = np.asarray(Image.open(tmp_path / "same.png")).astype(int)
    assert ((same[..., 0] - same[..., 2]) > 60)[:150].sum() == 0

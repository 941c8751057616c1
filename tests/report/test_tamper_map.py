"""The map as a file, places in words, and views from behind."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.view import from_behind, three_quarter_view
from meshmark.io import read_mesh
from meshmark.mesh import Mesh
from meshmark.report.tamper_map import write_tamper_map
from meshmark.segmentation.region_labels import region_labels
from tests.shapes import pebble


@pytest.mark.parametrize("scale", [1.0, 1.0 / 3.0])
def test_the_map_holds_the_vertices_exactly_and_in_order(tmp_path, scale):
    points, faces = pebble(20)
    mesh = Mesh(np.round(points * 64.0) / 64.0 * scale, faces)
    altered = np.arange(len(points)) % 3 == 0
    write_tamper_map(mesh, altered, tmp_path / "map.ply")
    back = read_mesh(tmp_path / "map.ply")
    assert np.array_equal(back.vertices, mesh.vertices)
    assert np.array_equal(back.faces, mesh.faces)
    colours = back.document.attributes().colors
    assert (colours[altered, 0] > colours[altered, 1] + 100).all()
    assert (np.ptp(colours[~altered, :3].astype(int), axis=1) < 20).all()
    assert back.document.summary()["elements"]["vertex"][-1] == "altered"
    assert (b"property double x" in (tmp_path / "map.ply").read_bytes()) == (scale != 1.0)


def test_a_view_from_behind_is_a_turn_about_the_upright_axis():
    points, _ = pebble(20)
    view = three_quarter_view(points)
    back = from_behind(view)
    assert back @ back.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(back) == pytest.approx(1.0)
    assert back[0] == pytest.approx(-view[0])
    assert from_behind(back) == pytest.approx(view)


def test_places_are_named_as_the_picture_shows_them():
    points, _ = pebble(20)
    view = three_quarter_view(points)
    seen = points @ view.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    corners = np.array([[0, 1, 1], [1, 0, 1], [0.5, 0.5, 0.5], [0.5, 1, 0], [0, 0.5, 0.5], [0.5, 0.5, 0]])
    named = region_labels(points, (low + corners * (high - low)) @ view)
    assert named == ["top left", "bottom right", "middle", "top back", "left", "back"]

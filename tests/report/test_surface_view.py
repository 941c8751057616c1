"""A view holds its surface upright and its layers vertex by vertex, in JSON."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.geometry.view import Stance, level_view
from meshmark.mesh import Mesh
from meshmark.report.surface_view import surface_view
from meshmark.report.view_layer import category_layer, heat_layer, surface_layer
from meshmark.report.view_surface import view_surface
from tests.counting import some
from tests.shapes import pebble

TYPES = {"uint8": "u1", "uint16": "<u2", "uint32": "<u4"}


def unpacked(packed: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed["data"]), TYPES[packed["type"]])


def viewed(mesh: Mesh, layers=(), **options):
    shown = view_surface(mesh, **options)
    view = surface_view(shown, [surface_layer(None), *layers], start="surface", label="a pebble")
    return json.loads(json.dumps(view, allow_nan=False))


def test_positions_are_those_of_the_mesh_to_a_step_of_the_grid():
    points, faces = pebble(20)
    mesh = Mesh(7.0 * points + 100.0, faces)
    view = viewed(mesh)
    high = np.array(view["box"]["high"])
    found = unpacked(view["positions"]).reshape(-1, 3) / 65535.0 * high
    expected = mesh.vertices @ level_view(mesh.vertices).T
    expected -= expected.min(axis=0)
    assert high.max() == 1.0
    np.testing.assert_allclose(found, expected / expected.max(), atol=1.0 / 65535)
    assert (unpacked(view["triangles"]).reshape(-1, 3) == faces).all()
    assert view["note"] == ""


def test_a_file_that_says_which_way_is_up_stands_so():
    stance = Stance(up=(0.0, 0.0, 1.0), front=(0.0, -1.0, 0.0))
    np.testing.assert_array_equal(level_view(np.zeros((1, 3)), stance), [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    points, faces = pebble(20)
    shown = view_surface(Mesh(points, faces), turn=level_view(points, stance))
    low, size = points.min(axis=0), np.ptp(points, axis=0).max()
    np.testing.assert_allclose(shown.points[:, 1], (points - low)[:, 2] / size)
    np.testing.assert_allclose(shown.points[:, 2], -(points - low)[:, 1] / size)


def test_a_large_model_is_shown_with_fewer_triangles_and_says_so():
    points, faces = pebble(60)
    mesh = Mesh(points, faces)
    height = (points[:, 2] - points[:, 2].min()) / np.ptp(points[:, 2])
    layer = heat_layer("height", "Height", height, [(0.0, "0"), (1.0, "1")])
    view = viewed(mesh, [layer], most=800)
    assert 400 < view["faces"] <= 850
    assert view["note"] == f"The view shows {view['faces']:,} of {len(faces):,} triangles."
    shown = view_surface(mesh, most=800)
    assert unpacked(view["triangles"]).max() == view["vertices"] - 1
    values = unpacked(view["layers"][1]["values"]) / 254.0
    np.testing.assert_allclose(values, height[shown.vertex], atol=0.003)
    own = view_surface(mesh).points[shown.vertex]
    assert np.linalg.norm(own - shown.points, axis=1).max() < 0.15


def test_seams_are_closed_and_values_follow_the_first_vertex():
    points, faces = pebble(20)
    apart = Mesh(points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    category = np.arange(len(apart.vertices)) % 300
    layer = category_layer("c", "C", category, [(str(i), "#000000") for i in range(300)])
    view = viewed(apart, [layer])
    assert view["vertices"] == len(points)
    first = view_surface(apart).vertex
    np.testing.assert_array_equal(unpacked(view["layers"][1]["values"]), category[first])


def test_heat_has_a_number_for_no_value():
    layer = heat_layer("h", "H", np.array([0.0, 0.5, 1.0, 7.0, -1.0, np.nan]), [(0.0, "0")], missing="none")
    assert layer.values is not None
    assert layer.values.tolist() == [0, 127, 254, 254, 0, 255]
    assert layer.legend is not None
    assert layer.legend["missing"]["label"] == "none"
    scale = [sum(bytes.fromhex(colour[1:])) for colour in some(layer.legend["colours"], least=8)]
    assert scale == sorted(scale, reverse=True), "the darker, the more"


def test_a_model_without_a_surface_has_no_view():
    with pytest.raises(InputError, match="1 faces, none with three different points"):
        viewed(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])))

"""Models in the colours of their materials, textures and vertices."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.io import read_mesh
from meshmark.mesh import Mesh
from meshmark.report.colours import to_srgb
from meshmark.report.common_layers import own_surface
from meshmark.report.own_colours import own_colours, own_panel
from meshmark.report.picture import render
from meshmark.report.view_surface import view_surface
from tests.counting import some
from tests.shapes import pebble
from tests.textured import CORNERS, FACES, FOUR, PLACES, textured_glb, textured_obj

LEFT, RIGHT, ABOVE, BELOW = 20, 60, 20, 60
QUARTERS = {(ABOVE, LEFT): 0, (ABOVE, RIGHT): 1, (BELOW, LEFT): 2, (BELOW, RIGHT): 3}


def drawn(mesh: Mesh) -> list[np.ndarray]:
    """Return the colour of each quarter of the square: above left, above right, below left, below right."""
    picture = render(own_panel(mesh, ""), 80, np.eye(3)).astype(int)
    return [picture[place] for place in QUARTERS]


def nearest(colour: np.ndarray) -> int:
    """Return which of the four colours of the image a lit colour is."""
    four = FOUR.reshape(-1, 3) / np.linalg.norm(FOUR.reshape(-1, 3).astype(float), axis=1)[:, None]
    return int((four @ (colour / np.linalg.norm(colour))).argmax())


@pytest.mark.parametrize("name", ["four.glb", "four.obj"])
def test_a_texture_is_drawn_where_it_lies(name, tmp_path):
    (textured_glb if name.endswith("glb") else textured_obj)(tmp_path / name)
    assert [nearest(colour) for colour in drawn(read_mesh(tmp_path / name))] == [0, 1, 2, 3]


def test_a_texture_repeats_itself_and_a_transform_moves_it(tmp_path):
    textured_glb(tmp_path / "far.glb", PLACES + np.array([3.0, -2.0]))
    assert [nearest(colour) for colour in drawn(read_mesh(tmp_path / "far.glb"))] == [0, 1, 2, 3]
    textured_glb(tmp_path / "moved.glb", extensions={"KHR_texture_transform": {"offset": [0.5, 0.0]}})
    assert [nearest(colour) for colour in drawn(read_mesh(tmp_path / "moved.glb"))] == [1, 0, 3, 2]


def test_colours_of_materials_are_drawn_without_a_texture(tmp_path):
    made = textured_glb(tmp_path / "four.glb")
    made.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.02, 0.02, 0.8, 1.0]}}]
    (tmp_path / "blue.glb").write_bytes(made.bytes())
    textured_obj(tmp_path / "red.obj", "map_Kd missing.png")
    for name, channel in some((("blue.glb", 2), ("red.obj", 0))):
        for colour in some(drawn(read_mesh(tmp_path / name))):
            assert colour[channel] > 2 * np.delete(colour, channel).max(), name


def test_colours_of_vertices_and_of_an_image_are_multiplied(tmp_path):
    made = textured_glb(tmp_path / "four.glb")
    made.primitive["attributes"]["COLOR_0"] = made.array(np.tile([1.0, 0.0, 0.0], (4, 1)))
    (tmp_path / "tinted.glb").write_bytes(made.bytes())
    red, green, blue, white = drawn(read_mesh(tmp_path / "tinted.glb"))
    assert min(red[0], white[0]) > 3 * max(green.max(), blue.max())
    assert max(colour[1:].max() for colour in (red, green, blue, white)) < 40


def test_what_is_broken_or_says_nothing_is_clay(tmp_path):
    made = textured_glb(tmp_path / "four.glb")
    made.tree["textures"][0]["source"] = 7
    (tmp_path / "broken.glb").write_bytes(made.bytes())
    assert own_colours(read_mesh(tmp_path / "broken.glb")).paint is None
    assert own_colours(Mesh(CORNERS, FACES)).paint is None
    made.tree["textures"][0]["source"] = 0
    made.tree["images"] = [{"uri": "../secret.png"}]
    (tmp_path / "outside.glb").write_bytes(made.bytes())
    assert own_colours(read_mesh(tmp_path / "outside.glb")).paint is None


def test_a_smaller_view_takes_the_texture_at_its_vertices(tmp_path):
    across = np.linspace(0.0, 1.0, 41)
    points = np.stack([*np.meshgrid(across, across, indexing="ij"), np.zeros((41, 41))], axis=-1).reshape(
        -1, 3
    )
    here = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = (part.ravel() for part in (here[:-1, :-1], here[1:, :-1], here[1:, 1:], here[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    made = textured_glb(tmp_path / "four.glb")
    fine = made.primitive
    fine["attributes"] = {
        "POSITION": made.array(points), "TEXCOORD_0": made.array(points[:, :2] * [1, -1] + [0, 1])
    }  # fmt: skip
    fine["indices"] = made.array(faces.ravel(), "u4")
    (tmp_path / "fine.glb").write_bytes(made.bytes())
    mesh = read_mesh(tmp_path / "fine.glb")
    layer = own_surface(mesh)
    corner = {tuple(place): number for number, place in enumerate(mesh.vertices[:, :2].round(3).tolist())}
    found = [
        layer.values[corner[place]] for place in ((0.25, 0.75), (0.75, 0.75), (0.25, 0.25), (0.75, 0.25))
    ]
    assert np.abs(np.array(found, int) - FOUR.reshape(-1, 3)).max() <= 2
    assert "vertices" in layer.note
    shown = view_surface(mesh, turn=np.eye(3), most=400)
    picture = render(own_colours(mesh).on(shown), 80, np.eye(3)).astype(int)
    assert [nearest(picture[place]) for place in QUARTERS] == [0, 1, 2, 3]
    whole = own_colours(mesh).on(view_surface(mesh, turn=np.eye(3)))
    assert whole.paint is not None


def test_a_mesh_of_vertex_colours_alone_looks_as_before(tmp_path):
    from meshmark.io import write_mesh

    write_mesh(Mesh(*pebble(20)), tmp_path / "plain.glb")
    mesh = read_mesh(tmp_path / "plain.glb")
    assert own_surface(mesh).values is None
    assert own_colours(mesh).at_vertices() is None
    assert (to_srgb(np.zeros((1, 3))) == 0).all()

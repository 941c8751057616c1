"""What a view holds of a painted surface: colours of corners, places on images, and the images within limits."""

from __future__ import annotations

import base64
import io

import numpy as np
from PIL import Image

from meshmark.io import read_mesh
from meshmark.io.paint import Paint
from meshmark.report.common_layers import own_surface
from meshmark.report.own_colours import own_colours
from meshmark.report.surface_view import surface_view
from meshmark.report.view_skin import fits, skin_of
from meshmark.report.view_surface import view_surface
from tests.report.test_surface_view import unpacked
from tests.textured import FACES, FOUR, PLACES, textured_glb


def paint(*images: np.ndarray, places: np.ndarray = PLACES) -> Paint:
    return Paint(factor=np.ones((2, 3)), image=np.zeros(2, np.int64), places=places[FACES], images=images)


def test_places_come_back_to_a_step_of_the_grid_without_whole_repeats():
    skin = skin_of(paint(FOUR, places=3.0 * PLACES + np.array([-7.0, 12.0])))
    low, high = np.array(skin["low"]), np.array(skin["high"])
    found = low + skin["places"] / 65535.0 * (high - low)
    np.testing.assert_allclose(found, 3.0 * PLACES[FACES], atol=1e-4)


def test_small_images_are_kept_to_the_pixel_and_large_ones_made_smaller():
    noise = np.random.default_rng(0).integers(0, 256, (1024, 1024, 3)).astype(np.uint8)
    small, large = (
        Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2])))
        for address in skin_of(paint(FOUR, *[noise] * 9))["images"][:2]
    )
    assert (np.asarray(small.convert("RGB")) == FOUR).all()
    assert max(large.size) <= 512
    assert fits(paint(*[FOUR] * 16))
    assert not fits(paint(*[FOUR] * 17))


def test_a_view_has_the_paint_where_it_has_all_triangles(tmp_path):
    textured_glb(tmp_path / "four.glb")
    mesh = read_mesh(tmp_path / "four.glb")
    shown = view_surface(mesh)
    (layer,) = surface_view(shown, [own_surface(mesh)], start="surface", label="a square")["layers"]
    assert layer["corners"]
    assert layer["note"] == ""
    assert unpacked(layer["values"]).tolist() == [255] * 18
    assert unpacked(layer["skin"]["image"]).tolist() == [1, 1]
    fewer = type(shown)(points=shown.points, faces=shown.faces, vertex=shown.vertex, shown_of=9)
    (layer,) = surface_view(fewer, [own_surface(mesh)], start="surface", label="a square")["layers"]
    assert "skin" not in layer
    assert "vertices" in layer["note"]
    assert len(unpacked(layer["values"])) == 12
    assert own_colours(mesh).on(fewer).paint is None

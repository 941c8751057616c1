from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from meshmark.errors import OutputError
from meshmark.geometry.view import three_quarter_view
from meshmark.mesh import Mesh
from meshmark.report.colours import heat, oklch, region_colours, to_linear, to_srgb
from meshmark.report.picture import Panel, panels, render
from meshmark.report.saliency_picture import saliency_picture
from meshmark.report.segmentation_picture import segmentation_picture
from meshmark.saliency import analyse
from meshmark.segmentation import segment
from tests.counting import some
from tests.shapes import sphere_with_a_spike

RED, BLUE = [0.8, 0.02, 0.02], [0.02, 0.02, 0.8]


def test_a_sphere_fills_a_disc_of_its_colour_lit_from_above() -> None:
    points, faces, tip = sphere_with_a_spike(60)
    points[tip] /= 1.3
    picture = render(
        Panel(caption="", points=points, faces=faces, colours=np.tile(RED, (len(points), 1))), 120, np.eye(3)
    ).astype(int)
    red = (picture[..., 0] > picture[..., 1] + 60) & (picture[..., 0] > picture[..., 2] + 60)
    assert red.sum() == pytest.approx(np.pi * (60 * 0.86) ** 2, rel=0.03)
    assert picture[30, 60, 0] > picture[90, 60, 0]


def test_the_nearer_surface_hides_the_other() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    points = np.concatenate([square, square + np.array([0.0, 0.0, 1.0])])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    colours = np.array([RED, RED, BLUE, BLUE])
    for view, channel in ((np.eye(3), 2), (np.diag([-1.0, 1.0, -1.0]), 0)):
        middle = render(Panel(caption="", points=points, faces=faces, colours=colours), 40, view)[20, 20]
        assert middle.argmax() == channel


def test_labels_are_drawn_flat_with_a_dark_border() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    panel = Panel(
        caption="",
        points=square,
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        colours=np.array([RED, BLUE]),
        labels=np.array([0, 1, 1, 0]),
    )
    row = render(panel, 80, np.eye(3))[40].astype(int)
    assert row[20].argmax() == 0
    assert row[60].argmax() == 2
    assert row[39:42].sum(axis=1).min() < 0.8 * min(row[20].sum(), row[60].sum())


def test_hidden_marks_are_not_drawn() -> None:
    points, faces, _ = sphere_with_a_spike()
    front, back = int(points[:, 2].argmax()), int(points[:, 2].argmin())
    plain, seen, hidden = (
        render(Panel(caption="", points=points, faces=faces, marks=np.array(marks, int)), 60, np.eye(3))
        for marks in ([], [front], [back])
    )
    assert (plain != seen).any()
    np.testing.assert_array_equal(plain, hidden)


def test_the_view_is_a_rotation_and_stands_a_model_on_its_foot() -> None:
    rng = np.random.default_rng(1)
    cone = rng.normal(size=(4000, 3))
    height = np.linspace(0.0, 1.0, 4000) ** 2
    cone[:, :2] *= (1.0 - height)[:, None] / np.linalg.norm(cone[:, :2], axis=1, keepdims=True)
    cone[:, 2] = 2.0 * height
    view = three_quarter_view(cone)
    np.testing.assert_allclose(view @ view.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(view) == pytest.approx(1.0)
    assert view[1, 2] > 0.9  # the tip of the cone, at +z, is up on the screen
    for flat in (np.zeros((1, 3)), np.outer(np.arange(9.0), [1.0, 2.0, 0.0])):
        assert np.linalg.det(three_quarter_view(flat)) == pytest.approx(1.0)


def test_pictures_of_results_are_png_of_the_size_asked_for(tmp_path: Path) -> None:
    points, faces, _ = sphere_with_a_spike()
    mesh = Mesh(points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    saliency_picture(mesh, analyse(mesh), tmp_path / "saliency.png", size=150)
    segmentation_picture(mesh, segment(mesh, 5), tmp_path / "regions.png", size=150)
    for name in ("saliency.png", "regions.png"):
        with Image.open(tmp_path / name) as picture:
            assert picture.format == "PNG"
            assert picture.width == 300


def test_a_place_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    points, faces, _ = sphere_with_a_spike()
    with pytest.raises(OutputError, match="cannot write"):
        panels([Panel(caption="", points=points, faces=faces)], tmp_path / "no" / "folder.png", size=50)


def test_colours_survive_the_round_trip_and_heat_darkens_evenly() -> None:
    every = np.arange(256)
    np.testing.assert_array_equal(to_srgb(to_linear(every / 255.0)), every)
    light = (heat(np.linspace(0.0, 1.0, 50)) @ [0.2126, 0.7152, 0.0722]) ** (1 / 3)
    assert (np.diff(light) < 0).all()
    np.testing.assert_allclose(oklch(1.0, 0.0, 0.0), 1.0, atol=1e-3)


def test_neighbouring_regions_look_different() -> None:
    points, faces, _ = sphere_with_a_spike(40)
    region = (np.arctan2(points[:, 1], points[:, 0]) * 2.0 + 7.0).astype(np.int64)
    colours = region_colours(region, faces, int(region.max()) + 1)
    for a, b in some({(int(region[f[0]]), int(region[f[1]])) for f in faces}):
        assert a == b or np.abs(np.cbrt(colours[a]) - np.cbrt(colours[b])).max() > 0.1

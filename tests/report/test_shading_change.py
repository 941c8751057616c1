"""The picture of an embedding shows where normals turned, and nothing where none did."""

from __future__ import annotations

import numpy as np
from PIL import Image

from meshmark.mesh import Mesh
from meshmark.report.shading_change import shading_picture
from tests.shapes import pebble


def panels(original: Mesh, marked: Mesh, path) -> list[np.ndarray]:
    shading_picture(original, marked, path, size=120)
    picture = np.asarray(Image.open(path)).astype(int)[:120]
    assert picture.shape == (120, 360, 3)
    return [picture[:, 120 * i : 120 * (i + 1)] for i in range(3)]


def reddest(picture: np.ndarray) -> int:
    return int((picture[..., 0] - picture[..., 2]).max())


def test_waves_are_red_in_the_third_panel_alone(tmp_path):
    points, faces = pebble(30)
    mesh = Mesh(points, faces)
    nowhere = panels(mesh, Mesh(points.copy(), faces), tmp_path / "same.png")
    assert (nowhere[0] == nowhere[1]).all()
    assert reddest(nowhere[2]) < 25
    raised = points * (1.0 + 0.02 * np.sin(20.0 * points[:, :1]))
    waves = panels(mesh, Mesh(raised, faces), tmp_path / "waves.png")
    assert reddest(waves[2]) > 80
    assert (waves[0] == nowhere[0]).all()


def test_a_surface_that_is_there_both_ways_round_is_no_redder_than_one_side_of_it(tmp_path):
    points, faces = pebble(30)
    raised = points * (1.0 + 0.002 * np.sin(20.0 * points[:, :1]))
    single = panels(Mesh(points, faces), Mesh(raised, faces), tmp_path / "single.png")
    doubled = np.vstack([faces, faces[:, ::-1]])
    both = panels(Mesh(points, doubled), Mesh(raised, doubled), tmp_path / "both.png")
    assert 25 < reddest(single[2]) < 250
    assert abs(reddest(both[2]) - reddest(single[2])) < 40

"""The sentence of a refusal names what is wrong with the model, as it was counted."""

from __future__ import annotations

import re

import numpy as np
import pytest

from meshmark.coding.message import PRESENCE, short_id
from meshmark.errors import CapacityError
from meshmark.marking import both_layers, embed, fewer_bits
from meshmark.mesh import Mesh
from meshmark.ownership.embedding_in_cells import embed_in_cells
from meshmark.ownership.embedding_task import EmbeddingTask
from tests.keys import ID, KEY
from tests.low_poly import box, welded
from tests.shapes import pebble

CUBE = welded(box((1, 1, 1), (1.0, 1.3, 1.7)))


def subdivided(points, faces):
    """Return the surface with each face in four."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    known, number = np.unique(edges, axis=0, return_inverse=True)
    number = number.reshape(-1) + len(points)
    (a, b, c), (x, y, z) = faces.T, number.reshape(3, -1)
    parts = [np.stack(part, axis=1) for part in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))]
    return np.concatenate([points, points[known].mean(axis=1)]), np.concatenate(parts)


def refusal(mesh: Mesh) -> str:
    """Return why the cells of a mesh cannot carry the id; its points may."""
    task = EmbeddingTask(mesh=mesh, key=KEY, identity=ID, strength="standard", rms=8e-4)
    with pytest.raises(CapacityError) as caught:
        embed_in_cells(task)
    return str(caught.value)


def test_long_triangles_are_named_and_subdividing_helps():
    points, faces = pebble(14)
    said = re.search(
        r"its triangles are ([\d.]+) times as long as a patch is wide", refusal(Mesh(points, faces))
    )
    assert said
    assert float(said[1]) > 1.0
    for _ in range(2):
        points, faces = subdivided(points, faces)
    assert embed(Mesh(points, faces), KEY, id=ID, layers="ownership").id == ID


def test_a_surface_with_two_sides_is_called_doubled():
    points, faces = pebble(40)
    text = refusal(Mesh(points, np.concatenate([faces, faces[:, ::-1]])))
    assert "100% of the surface is there twice" in text


def test_leaves_that_point_every_way_are_named():
    random = np.random.default_rng(5)
    corners = random.normal(size=(6000, 1, 3)) + 0.15 * random.normal(size=(6000, 3, 3))
    text = refusal(Mesh(corners.reshape(-1, 3), np.arange(18000).reshape(-1, 3)))
    assert "faces that point every way" in text
    assert "too few points" not in text


def test_thin_scattered_parts_are_named():
    # Small flat tiles, all facing one way, far from each other.
    x, y = np.meshgrid(np.arange(40.0), np.arange(40.0))
    middle = np.stack([x.ravel(), y.ravel(), np.zeros(1600)], axis=1)
    tile = 0.05 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    points = (middle[:, None] + tile).reshape(-1, 3)
    faces = (4 * np.arange(1600)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    assert "too small or too narrow for a patch" in refusal(Mesh(points, faces))


def test_where_points_cannot_carry_it_either_both_reasons_are_said():
    with pytest.raises(CapacityError, match=r"times as long as a patch.*; its 8 points carry \d+ bits .*88"):
        embed(Mesh(*CUBE), KEY, id=ID, layers="ownership")


def test_room_for_authentication_alone_is_said(monkeypatch):
    def refuse(*_arguments, **_options):
        raise CapacityError("no room")

    monkeypatch.setattr(both_layers, "embed_repeated", refuse)
    monkeypatch.setattr(fewer_bits, "embed_repeated", refuse)
    with pytest.raises(CapacityError, match=r"no room; for --layers authentication, .* there is room"):
        embed(Mesh(*pebble(40)), KEY, id=ID)


def test_no_room_for_authentication_alone_is_not_promised():
    with pytest.raises(CapacityError) as caught:
        embed(Mesh(*CUBE), KEY, id=ID)
    assert "--layers authentication" not in str(caught.value)


def test_fewer_bits_are_tried_with_the_last_digits_of_the_id_that_was_asked_for(monkeypatch):
    tried = []

    def refuse(*_arguments, id, **_options):
        tried.append(id)
        raise CapacityError("no room")

    monkeypatch.setattr(both_layers, "embed_repeated", refuse)
    monkeypatch.setattr(fewer_bits, "embed_repeated", refuse)
    with pytest.raises(CapacityError, match="no room"):
        embed(Mesh(*CUBE), KEY, id=0x1234_5678_9ABC_DEF0, layers="ownership")
    assert tried == [0x1234_5678_9ABC_DEF0, short_id(0x9ABC_DEF0), PRESENCE]

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.geometry import weld as module
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh

SOME = st.integers(0, 40)


def random_soup(seed: int, corners: int, places: int) -> Mesh:
    rng = np.random.default_rng(seed)
    vertices = rng.integers(-places, places + 1, (corners + 3, 3)) * 0.1
    vertices[rng.random(vertices.shape) < 0.2] = -0.0
    faces = rng.integers(0, corners + 3, (corners, 3))
    return Mesh(vertices, faces)


@settings(max_examples=60, deadline=None)
@given(seed=SOME, corners=SOME, places=st.integers(0, 4))
def test_points_are_the_distinct_rows_in_order_of_appearance(seed: int, corners: int, places: int) -> None:
    mesh = random_soup(seed, corners, places)
    welded = weld(mesh)
    rows = [tuple(row) for row in mesh.vertices.tolist()]  # -0.0 == 0.0 also as dictionary keys
    place = {row: index for index, row in enumerate(dict.fromkeys(rows))}
    assert welded.point_of_vertex.tolist() == [place[row] for row in rows]
    assert [tuple(row) for row in welded.points.tolist()] == list(place)
    assert welded.vertex_of_point.tolist() == [rows.index(row) for row in place]
    expected = [face for face in welded.point_of_vertex[mesh.faces].tolist() if len(set(face)) == 3]
    assert welded.faces.tolist() == expected


def test_colliding_hashes_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = random_soup(7, 60, 2)
    expected = weld(mesh)
    monkeypatch.setattr(module, "_hash_rows", lambda rows: np.zeros(len(rows), np.uint64))
    welded = weld(mesh)
    np.testing.assert_array_equal(welded.points, expected.points)
    np.testing.assert_array_equal(welded.point_of_vertex, expected.point_of_vertex)


def test_an_empty_mesh_stays_empty() -> None:
    welded = weld(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64)))
    assert welded.points.shape == (0, 3)
    assert welded.faces.shape == (0, 3)
    assert welded.point_of_vertex.shape == (0,)

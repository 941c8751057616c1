"""Facts about models whose facts are known."""

from __future__ import annotations

import lzma
from io import BytesIO

import numpy as np
import pytest
import trimesh

from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.shape import describe
from tests.counting import some
from tests.packed import read_packed


def mesh_of(model: trimesh.Trimesh) -> Mesh:
    return Mesh(np.array(model.vertices), np.array(model.faces))


def test_a_box():
    shape = describe(mesh_of(trimesh.creation.box((2.0, 3.0, 6.0))))
    assert (shape.vertices, shape.points, shape.faces, shape.parts) == (8, 8, 12, 1)
    assert (shape.open_edges, shape.branching_edges, shape.closed) == (0, 0, True)
    assert shape.size == (2.0, 3.0, 6.0)
    assert shape.diagonal == pytest.approx(7.0)
    assert shape.area == pytest.approx(2 * (6 + 12 + 18))


def test_a_triangle_soup_of_two_boxes_is_closed_and_in_two_parts():
    one = trimesh.creation.box()
    other = trimesh.creation.box(transform=trimesh.transformations.translation_matrix([5, 0, 0]))
    corners = np.concatenate([one.triangles, other.triangles]).reshape(-1, 3)
    shape = describe(Mesh(corners, np.arange(len(corners)).reshape(-1, 3)))
    assert (shape.vertices, shape.points, shape.parts, shape.closed) == (72, 16, 2, True)


def test_holes_and_fins_are_counted_and_loose_vertices_are_no_parts():
    box = trimesh.creation.box()
    open_box = describe(Mesh(np.array(box.vertices), np.array(box.faces)[1:]))
    assert (open_box.open_edges, open_box.closed) == (3, False)
    fin = describe(
        Mesh(
            np.vstack([box.vertices, [[9.0, 9, 9], [8, 8, 8]]]),
            np.vstack([box.faces, [*box.edges_unique[0], 8]]),
        )
    )
    assert (fin.branching_edges, fin.open_edges, fin.closed) == (1, 2, False)
    assert (fin.points, fin.parts) == (10, 1)


def test_no_extent_is_refused():
    with pytest.raises(InputError):
        describe(Mesh(np.ones((3, 3)), np.array([[0, 1, 2]])))


@pytest.mark.shared
def test_as_trimesh_counts_them(shared_data):
    packed = sorted((shared_data / "models" / "test").glob("*.off.xz"))
    for path in some((path for path in packed if path.stat().st_size < 30_000), least=3):
        shape = describe(read_packed(path))
        other = trimesh.load_mesh(BytesIO(lzma.decompress(path.read_bytes())), "off", process=False)
        assert shape.faces == len(other.faces), path
        assert shape.area == pytest.approx(other.area, rel=1e-5), path

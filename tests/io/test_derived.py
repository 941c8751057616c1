"""Meshes with other faces than their file keep the attributes of the vertices that stayed."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.io import read_mesh, write_mesh
from meshmark.io.derived import derived
from meshmark.mesh import Mesh

PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
0 0 0 10 0 0
1 0 0 20 0 0
1 1 0 30 0 0
0 1 0 40 0 0
3 0 1 2
3 0 2 3
"""
OBJ = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0.1 0.2
vt 0.3 0.4
f 1/1 2/2 3/1
f 1/2 3/1 4/2
"""


@pytest.fixture
def cut(tmp_path):
    (tmp_path / "a.ply").write_text(PLY)
    mesh = read_mesh(tmp_path / "a.ply")
    vertices = np.concatenate([mesh.vertices[1:], [[1.1, 0.1, 0.0]]])
    return derived(mesh, vertices, np.array([[0, 1, 2], [3, 0, 1]]), np.array([1, 2, 3, -1]))


def test_attributes_follow_and_new_vertices_take_the_nearest(cut, tmp_path):
    write_mesh(cut, tmp_path / "b.ply")
    back = read_mesh(tmp_path / "b.ply")
    assert np.allclose(back.vertices, cut.vertices)
    assert np.array_equal(back.faces, cut.faces)
    assert back.document.attributes().colors[:, 0].tolist() == [20, 30, 40, 20]


@pytest.mark.parametrize("name", ["b.obj", "b.glb", "b.stl"])
def test_a_derived_mesh_can_be_converted(cut, tmp_path, name):
    write_mesh(cut, tmp_path / name)
    assert len(read_mesh(tmp_path / name).faces) == 2


def test_one_corner_of_a_seam_speaks_for_all(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    mesh = read_mesh(tmp_path / "a.obj")
    made = derived(mesh, mesh.vertices[:3], mesh.faces[:1], np.arange(3))
    found = made.document.attributes()
    assert found.seams is None
    assert found.texcoords.shape == (3, 2)
    assert found.texcoords[1] == pytest.approx([0.3, 0.4])
    write_mesh(made, tmp_path / "b.obj")
    assert len(read_mesh(tmp_path / "b.obj").vertices) == 3


def test_a_mesh_made_in_memory_stays_one():
    mesh = Mesh(np.eye(3), [[0, 1, 2]])
    assert derived(mesh, mesh.vertices, mesh.faces, np.arange(3)).document is None

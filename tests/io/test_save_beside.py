"""Saving next to other models: nothing that belongs to another one is replaced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import InputError, MeshmarkError
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from tests.io.gltf_samples import cube


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def external_cube(folder: Path) -> Path:
    path = folder / "cube.gltf"
    path.write_bytes(cube().external(folder))
    return path


def test_unmoved_model_beside_its_input_shares_the_buffer(tmp_path):
    path = external_cube(tmp_path)
    before = contents(tmp_path)
    write_mesh(read_mesh(path), tmp_path / "copy.gltf")
    after = contents(tmp_path)
    assert after.pop("copy.gltf") == before["cube.gltf"]
    assert after == before


def test_a_buffer_of_another_model_is_never_replaced(tmp_path):
    source, other = tmp_path / "source", tmp_path / "other"
    source.mkdir()
    other.mkdir()
    mesh = read_mesh(external_cube(source))
    moved = mesh.with_vertices(mesh.vertices * 1.01)
    write_mesh(moved, other / "cube.gltf")  # keeps the buffer's name, as it keeps its own
    before = contents(other)
    with pytest.raises(InputError, match="another model may need"):
        write_mesh(mesh, other / "second.gltf")
    assert contents(other) == before
    write_mesh(mesh, other / "cube.gltf")  # replacing the model replaces its buffer
    np.testing.assert_array_equal(read_mesh(other / "cube.gltf").vertices, mesh.vertices)


def test_verification_sees_complete_files_and_stops_the_save(tmp_path):
    source, target = tmp_path / "source", tmp_path / "target"
    source.mkdir()
    target.mkdir()
    mesh = read_mesh(external_cube(source))
    moved = mesh.with_vertices(mesh.vertices * 1.01)
    seen = []

    def refuse(path: Path) -> None:
        seen.append(read_mesh(path).vertices)
        raise MeshmarkError("no")

    with pytest.raises(MeshmarkError, match=r"^no$"):
        write_mesh(moved, target / "marked.gltf", verify=refuse)
    assert contents(target) == {}
    assert list(target.iterdir()) == []
    write_mesh(moved, target / "marked.gltf", verify=lambda path: seen.append(read_mesh(path).vertices))
    np.testing.assert_array_equal(seen[0], read_mesh(target / "marked.gltf").vertices)
    np.testing.assert_array_equal(seen[1], seen[0])


def test_a_mesh_made_in_memory_is_written_without_loss(tmp_path):
    vertices = np.random.default_rng(0).normal(size=(5, 3))
    mesh = Mesh(vertices, np.array([[0, 1, 2], [2, 3, 4]]))
    for name in ("a.off", "a.obj", "a.ply"):  # the others hold single precision
        write_mesh(mesh, tmp_path / name)
        np.testing.assert_allclose(read_mesh(tmp_path / name).vertices, vertices, rtol=0, atol=1e-15)

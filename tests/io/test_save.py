"""Saving: complete or absent, the input untouched, conversions that say what they drop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.io import FORMATS, conform, read_mesh, write_mesh
from meshmark.io.formats import OTHER_NAMES
from meshmark.mesh import Mesh
from tests.counting import some
from tests.io.saving import TETRAHEDRON, files_below
from tests.io.text_samples import SAMPLES

EXTENSIONS = [extension for entry in FORMATS.values() for extension in entry.extensions]


@pytest.mark.parametrize("packed", ["", ".gz"])
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_a_mesh_made_in_memory_is_written_and_read_back(tmp_path: Path, extension: str, packed: str) -> None:
    path = tmp_path / f"made{extension}{packed}"
    report = write_mesh(TETRAHEDRON, path)
    assert report.files[0] == path
    assert report.dropped == ()
    again = read_mesh(path)
    np.testing.assert_allclose(
        again.vertices[again.faces], TETRAHEDRON.vertices[TETRAHEDRON.faces], atol=1e-6
    )
    exact = extension in (".off", ".obj", ".ply")
    assert not exact or np.array_equal(again.vertices, TETRAHEDRON.vertices)
    assert set(files_below(tmp_path)) == {file.name for file in report.files}


@pytest.mark.parametrize("packed", ["", ".gz"])
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_saving_unmoved_gives_the_same_bytes(tmp_path: Path, extension: str, packed: str) -> None:
    path, out = tmp_path / f"made{extension}{packed}", tmp_path / "out"
    out.mkdir()
    write_mesh(TETRAHEDRON, path)
    write_mesh(read_mesh(path), out / path.name)
    assert files_below(out) == {name: data for name, data in files_below(tmp_path).items() if "/" not in name}


def test_moved_and_conformed(source: Path, tmp_path: Path) -> None:
    mesh = read_mesh(source)
    moved = mesh.with_vertices(mesh.vertices + 1 / 3)
    write_mesh(moved, tmp_path / "out.obj")
    np.testing.assert_array_equal(read_mesh(tmp_path / "out.obj").vertices, conform(mesh, moved.vertices))
    np.testing.assert_array_equal(conform(TETRAHEDRON, TETRAHEDRON.vertices), TETRAHEDRON.vertices)


def test_equal_meshes_give_equal_files(tmp_path: Path) -> None:
    for extension in some(EXTENSIONS):
        (tmp_path / "b").mkdir(exist_ok=True)
        write_mesh(TETRAHEDRON, tmp_path / f"a{extension}.gz")
        write_mesh(TETRAHEDRON, tmp_path / "b" / f"a{extension}.gz")
        assert (tmp_path / f"a{extension}.gz").read_bytes() == (
            tmp_path / "b" / f"a{extension}.gz"
        ).read_bytes()


@pytest.mark.parametrize("name", ["off", "stcnoff", "obj", "obj colours", "ply mixed up", "stl"])
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_conversion_keeps_the_surface(tmp_path: Path, name: str, extension: str) -> None:
    sample = SAMPLES[name]
    path = tmp_path / f"in{sample.suffix}"
    path.write_bytes(sample.data)
    mesh = read_mesh(path)
    write_mesh(mesh, tmp_path / f"out{extension}")
    again = read_mesh(tmp_path / f"out{extension}")
    np.testing.assert_allclose(again.vertices[again.faces], mesh.vertices[mesh.faces], atol=1e-6)


def test_conversion_keeps_attributes_and_says_what_it_drops(tmp_path: Path) -> None:
    path = tmp_path / "in.off"
    path.write_bytes(SAMPLES["stcnoff"].data)
    mesh = read_mesh(path)
    assert mesh.document is not None
    wanted = mesh.document.attributes()
    for extension in (".obj", ".ply", ".glb", ".gltf"):
        report = write_mesh(mesh, tmp_path / f"out{extension}")
        assert report.dropped == (("opacity",) if extension == ".obj" else ())
        document = read_mesh(tmp_path / f"out{extension}").document
        assert document is not None
        found = document.attributes()
        for field in ("normals", "texcoords", "colors"):
            ours, theirs = getattr(wanted, field), getattr(found, field)
            channels = 3 if field == "colors" and extension == ".obj" else None
            np.testing.assert_allclose(theirs[:, :channels], ours[:, :channels], atol=1e-6)
    assert write_mesh(mesh, tmp_path / "out.stl").dropped == (
        "normals",
        "texture coordinates",
        "vertex colours",
    )


def test_seams_are_split_only_where_the_target_keeps_them(source: Path, tmp_path: Path) -> None:
    data = b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
    data += b"f 1/1 2/2 3/3\nf 1/3 3/3 4/1\nf 2/2 1/3 4/1\n"
    source.write_bytes(data)
    mesh = read_mesh(source)
    write_mesh(mesh, tmp_path / "a.ply")
    split = read_mesh(tmp_path / "a.ply")
    assert len(split.vertices) == 5
    assert split.document is not None
    found = split.document.attributes()
    assert found.texcoords is not None
    assert found.colors is not None
    np.testing.assert_array_equal(split.vertices[split.faces], mesh.vertices[mesh.faces])
    np.testing.assert_array_equal(found.texcoords[split.faces[1]], [[0, 1], [0, 1], [0, 0]])
    np.testing.assert_array_equal(found.colors[split.faces[1, :2], :3], [[255, 0, 0], [0, 0, 255]])
    report = write_mesh(mesh, tmp_path / "b.stl")
    assert "texture coordinates" in report.dropped
    np.testing.assert_array_equal(
        read_mesh(tmp_path / "b.stl").vertices.reshape(-1, 3, 3), mesh.vertices[mesh.faces]
    )


def test_formats_without_a_name(source: Path, tmp_path: Path) -> None:
    mesh = read_mesh(source)
    write_mesh(mesh, tmp_path / "plain")
    assert (tmp_path / "plain").read_bytes() == source.read_bytes()
    with pytest.raises(InputError, match="no extension of a known format"):
        write_mesh(TETRAHEDRON, tmp_path / "plain")


def test_the_extension_of_the_input_may_be_kept(source: Path, tmp_path: Path) -> None:
    odd = tmp_path / "scan.dat"
    odd.write_bytes(source.read_bytes())
    write_mesh(read_mesh(odd), tmp_path / "copy.dat")
    assert (tmp_path / "copy.dat").read_bytes() == source.read_bytes()


@pytest.mark.parametrize(("extension", "format_"), OTHER_NAMES.items())
def test_other_names_of_formats(tmp_path: Path, extension: str, format_: str) -> None:
    write_mesh(TETRAHEDRON, tmp_path / f"a{extension}")
    write_mesh(TETRAHEDRON, tmp_path / f"a.{format_}")
    mesh = read_mesh(tmp_path / f"a{extension}")
    assert mesh.document is not None
    assert mesh.document.format == format_
    assert (tmp_path / f"a{extension}").read_bytes() == (tmp_path / f"a.{format_}").read_bytes()


def test_other_faces_than_the_files(source: Path, tmp_path: Path) -> None:
    mesh = read_mesh(source)
    with pytest.raises(InputError, match="other faces"):
        write_mesh(Mesh(mesh.vertices, mesh.faces[:2], mesh.document), tmp_path / "out.obj")

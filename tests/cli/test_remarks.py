"""What is odd in a file is told by `info` and `embed`, and kept."""

from __future__ import annotations

import gzip
import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from tests.counting import some
from tests.shapes import pebble


@pytest.fixture(scope="module")
def sphere(tmp_path_factory) -> bytes:
    """A small bumpy sphere as a binary STL."""
    folder = tmp_path_factory.mktemp("sphere")
    write_mesh(Mesh(*pebble(50)), folder / "sphere.stl")
    return (folder / "sphere.stl").read_bytes()


def odd_files(stl: bytes) -> dict[str, tuple[bytes, str]]:
    """Return files by name, each with a part of the remark that it deserves."""
    return {
        "tail.stl": (stl + b"\n", "1 byte follows the data that the header declares"),
        "zero.stl": (stl[:80] + struct.pack("<I", 0) + stl[84:], "the header declares 0 facets"),
    }


@pytest.mark.parametrize("name", ["tail.stl", "zero.stl"])
def test_info_and_embed_remark(cli, files, tmp_path: Path, sphere: bytes, name: str) -> None:
    content, says = odd_files(sphere)[name]
    (tmp_path / name).write_bytes(content)
    ran = cli("info", tmp_path / name, "--json")
    assert ran.code == 0
    (remark,) = json.loads(ran.out)["remarks"]
    assert says in remark
    assert ran.err == f"meshmark: {tmp_path / name}: {remark}\n"
    ran = cli(
        "embed",
        tmp_path / name,
        tmp_path / f"out-{name}",
        "--key",
        files.key,
        "--layers",
        "ownership",
        "--json",
    )
    assert ran.code == 0, ran
    assert json.loads(ran.out)["remarks"] == [f"{name}: {remark}"]
    assert ran.err == f"meshmark: {name}: {remark}\n"
    written = (tmp_path / f"out-{name}").read_bytes()
    assert written[:84] == content[:84]
    assert (
        written[84 + 50 * ((len(content) - 84) // 50) :] == content[84 + 50 * ((len(content) - 84) // 50) :]
    )


def test_a_model_in_an_archive_is_marked_in_it(cli, files, tmp_path: Path) -> None:
    path, out = tmp_path / "thing.zip", tmp_path / "marked.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("files/pebble.ply", gzip.decompress(files.model.read_bytes()))
        archive.writestr("LICENSE.txt", "free")
    ran = cli("embed", path, out, "--key", files.key, "--layers", "ownership", "--json")
    assert ran.code == 0, ran
    says = "the model in this zip archive is files/pebble.ply, beside 1 other file"
    assert json.loads(ran.out)["remarks"] == [f"thing.zip: {says}"]
    assert (
        json.loads(cli("extract", out, "--key", files.key, "--json").out)["id"] == json.loads(ran.out)["id"]
    )
    with zipfile.ZipFile(out) as archive:
        assert archive.read("LICENSE.txt") == b"free"
        assert archive.namelist() == ["files/pebble.ply", "LICENSE.txt"]


def test_an_ordinary_file_gives_no_remark(cli, files) -> None:
    ran = cli("info", files.model, "--json")
    assert json.loads(ran.out)["remarks"] == []
    assert ran.err == ""


# Files from the field that are no models, and what their refusal says.
REFUSED = {
    "3mf_wrong_error_line.3mf": "at line 1923: unbound prefix",
    "not_3mf.usdz": "is a USDZ package",
}


@pytest.mark.shared
@pytest.mark.parametrize("name", REFUSED)
def test_a_file_from_the_field_that_is_no_model_is_refused(cli, shared_data: Path, name: str) -> None:
    ran = cli("info", shared_data / "field" / name, "--json")
    assert ran.code == 2, ran
    assert REFUSED[name] in ran.err


@pytest.mark.shared
def test_the_files_from_the_field_are_read_and_saved_to_the_byte(
    cli, tmp_path: Path, shared_data: Path
) -> None:
    kinds = ("3mf_", "obj_", "ply_", "stl_", "not_")
    odd = [path for path in sorted((shared_data / "field").iterdir()) if path.name.startswith(kinds)]
    for path in some((path for path in odd if path.name not in REFUSED), least=14):
        ran = cli("info", path, "--json")
        assert ran.code == 0, ran
        mesh = read_mesh(path)
        out = tmp_path / path.name
        write_mesh(mesh, out)
        assert out.read_bytes() == path.read_bytes()
        assert mesh.document is not None
        moved = mesh.document.conform(mesh.vertices + 1e-3 * np.ptp(mesh.vertices))
        out.unlink()
        write_mesh(mesh.with_vertices(moved), out)
        np.testing.assert_array_equal(read_mesh(out).vertices, moved)

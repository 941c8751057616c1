"""A zip archive of one model: the model is marked in it, and every other byte of it stays."""

from __future__ import annotations

import gzip
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError, InputError
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from tests.io.binary_samples import binary_ply, binary_stl
from tests.io.text_samples import SAMPLES
from tests.io.threemf_samples import package, simple

METHODS = [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
MODELS = {
    "files/Model.OBJ": SAMPLES["obj"].data,
    "a.off": SAMPLES["off"].data,
    "a.ply": binary_ply("<", ("float",) * 3)[0],
    "a/b/c.stl": binary_stl(),
    "a.3mf": package(simple()),
}


def zipped(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        archive.comment = b"from a site"
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name, (2001, 2, 3, 4, 5, 6)), content, method)
    return packed.getvalue()


def contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        assert archive.comment == b"from a site"
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", MODELS)
def test_the_same_archive_is_written_back(name: str, method: int, tmp_path: Path) -> None:
    others = {
        "images/": b"",
        "images/a.png": b"\x89PNG" * 99,
        "LICENSE.txt": b"free",
        f"__MACOSX/._{name}": b"x",
    }
    path, out = tmp_path / "thing.zip", tmp_path / "out.zip"
    path.write_bytes(zipped({**others, name: MODELS[name], "README": b"print it"}, method))
    mesh = read_mesh(path)
    assert mesh.document is not None
    assert mesh.document.remarks[0] == f"the model in this zip archive is {name}, beside 4 other files"
    assert mesh.document.side_files() == ()
    write_mesh(mesh, out)
    assert out.read_bytes() == path.read_bytes()

    vertices = mesh.document.conform(mesh.vertices * 1.25)
    (tmp_path / Path(name).name).write_bytes(MODELS[name])
    alone = read_mesh(tmp_path / Path(name).name)
    assert write_mesh(mesh.with_vertices(vertices), out).dropped == ()
    report = write_mesh(alone.with_vertices(vertices), tmp_path / f"alone{Path(name).suffix}")
    before, after = contents(path), contents(out)
    assert list(before) == list(after)
    assert after[name] == report.files[0].read_bytes()
    assert {member: after[member] for member in after if member != name} == {
        member: before[member] for member in before if member != name
    }
    np.testing.assert_array_equal(read_mesh(out).vertices, vertices)


def test_the_model_alone_is_written_where_the_name_says_so(tmp_path: Path) -> None:
    path = tmp_path / "thing.zip"
    path.write_bytes(zipped({"a.stl": binary_stl(), "notes.txt": b"n"}))
    report = write_mesh(read_mesh(path), tmp_path / "out.stl")
    assert (tmp_path / "out.stl").read_bytes() == binary_stl()
    assert report.dropped == ("other files in the zip archive",)
    report = write_mesh(read_mesh(path), tmp_path / "out.ply")
    assert "other files in the zip archive" in report.dropped
    path.write_bytes(zipped({"a.stl": binary_stl()}))
    assert write_mesh(read_mesh(path), tmp_path / "out.stl").dropped == ()


def test_an_archive_under_another_name_stays_one(tmp_path: Path) -> None:
    path = tmp_path / "thing.stl"
    path.write_bytes(zipped({"a.stl": binary_stl()}))
    write_mesh(read_mesh(path), tmp_path / "out.stl")
    assert (tmp_path / "out.stl").read_bytes() == path.read_bytes()


def test_no_archive_is_written_where_none_was_read(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(binary_stl())
    for mesh in (read_mesh(tmp_path / "a.stl"), Mesh(np.eye(3), np.array([[0, 1, 2]]))):
        with pytest.raises(InputError):
            write_mesh(mesh, tmp_path / "out.zip")
    assert [path.name for path in tmp_path.iterdir()] == ["a.stl"]


def test_files_beside_the_archive_are_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "scene.mtl").write_text("map_Kd wood.png")
    (tmp_path / "wood.png").write_bytes(b"png")
    (tmp_path / "thing.zip").write_bytes(zipped({"a.obj": SAMPLES["obj"].data}))
    mesh = read_mesh(tmp_path / "thing.zip")
    (tmp_path / "out").mkdir()
    write_mesh(mesh, tmp_path / "out" / "thing.zip")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thing.zip"]


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("a.zip", zipped({"a.stl": binary_stl(), "b.off": b"OFF"}), "2 models (a.stl, b.off), expected one"),
        (
            "a.zip",
            zipped({f"{k}.stl": binary_stl() for k in range(9)}),
            "9 models (0.stl, 1.stl, 2.stl, ...)",
        ),
        (
            "a.zip",
            zipped({"a.txt": b"OFF", ".a.stl": b"x"}),
            "without a model in it, expected one file of .glb",
        ),
        ("a.docx", zipped({"[Content_Types].xml": b"<Types/>"}), "without a model in it"),
        ("a.usdz", zipped({"a.usdc": b"PXR"}), "is a USDZ package, expected one of .glb"),
        ("a.zip", zipped({"a.usda": b"#usda", "a.obj": SAMPLES["obj"].data}), "is a USDZ package"),
        ("a.stl", zipped({"a.usda": b"#usda"}), "is a USDZ package"),
        ("a.zip", zipped({"a.stl": b""}), "has 0 bytes"),
        ("a.zip.gz", gzip.compress(zipped({"a.stl": binary_stl()})), "is a gzipped zip archive"),
        (
            "a.zip",
            zipped({"a.gltf": b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin"}]}'}),
            "a.gltf",
        ),
        ("a.zip", zipped({"a.stl": binary_stl()})[:-30], "not a readable zip file"),
        ("a.zip", zipped({"a.stl": bytes(90_000_000)}), "no model of its size"),
    ],
)
def test_other_archives_are_refused_in_one_sentence(
    name: str, data: bytes, says: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_mesh(tmp_path / name)
    assert says in str(caught.value)
    assert name in str(caught.value)
    assert "3MF" not in str(caught.value)


def test_an_encrypted_member_is_named(tmp_path: Path) -> None:
    data = bytearray(zipped({"a.stl": binary_stl()}, zipfile.ZIP_STORED))
    data[6] |= 1
    data[data.index(b"PK\1\2") + 8] |= 1
    (tmp_path / "a.zip").write_bytes(data)
    with pytest.raises(FormatError, match=r"a\.stl is encrypted, expected plain content"):
        read_mesh(tmp_path / "a.zip")


def test_a_3mf_package_is_none_of_these(tmp_path: Path) -> None:
    for name in ("a.3mf", "a", "a.zip"):
        (tmp_path / name).write_bytes(package(simple()))
        mesh = read_mesh(tmp_path / name)
        assert mesh.document is not None
        assert mesh.document.format == "3mf"
        assert mesh.document.remarks == ()

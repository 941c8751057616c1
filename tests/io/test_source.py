"""Reading: formats by content and by name, gzip, and files that are none."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError, InputError
from meshmark.io import FORMATS, read_mesh, write_mesh
from meshmark.io import source as source_module
from meshmark.io.formats import detect_format, format_of_name
from meshmark.io.gzip_data import gzipped
from meshmark.mesh import Mesh
from tests.counting import some
from tests.io.text_samples import SAMPLES

OFF = SAMPLES["off"].data


def test_the_table_of_formats() -> None:
    assert set(FORMATS) == {"off", "obj", "ply", "stl", "glb", "gltf", "3mf"}
    for name, entry in some(FORMATS.items()):
        assert entry.name == name
        assert format_of_name(Path(f"A.B{entry.extensions[0].upper()}.GZ")) is entry
    assert format_of_name(Path("off")) is None


@pytest.mark.parametrize("name", SAMPLES)
def test_content_alone_tells_the_format(name: str, tmp_path: Path) -> None:
    sample = SAMPLES[name]
    for wrong in ("model", "model.glb", "model.stl", "model.ply", "model.gz"):
        path = tmp_path / wrong
        path.write_bytes(sample.data)
        document = read_mesh(path).document
        assert document is not None
        assert document.format == sample.suffix[1:]


def test_every_written_format_is_recognised_without_its_name(tmp_path: Path) -> None:
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    for name, entry in some(FORMATS.items()):
        write_mesh(mesh, tmp_path / f"a{entry.extensions[0]}")
        data = (tmp_path / f"a{entry.extensions[0]}").read_bytes()
        assert detect_format(data, Path("unknown")).name == name


def test_gzip_keeps_its_bytes_where_nothing_moved(tmp_path: Path) -> None:
    path = tmp_path / "model.off.gz"
    path.write_bytes(gzip.compress(OFF, mtime=12345))
    mesh = read_mesh(path)
    write_mesh(mesh, tmp_path / "same.off.gz")
    assert (tmp_path / "same.off.gz").read_bytes() == path.read_bytes()
    write_mesh(mesh, tmp_path / "plain.off")
    assert (tmp_path / "plain.off").read_bytes() == OFF
    moved = mesh.with_vertices(mesh.vertices * 2)
    write_mesh(moved, tmp_path / "moved.off.gz")
    written = (tmp_path / "moved.off.gz").read_bytes()
    assert written == gzipped(gzip.decompress(written))
    np.testing.assert_array_equal(read_mesh(tmp_path / "moved.off.gz").vertices, mesh.vertices * 2)
    assert mesh.document is not None
    assert mesh.document.summary()["gzipped"] is True


def test_gzip_without_the_name_stays_gzip(tmp_path: Path) -> None:
    (tmp_path / "model.off").write_bytes(gzip.compress(OFF))
    write_mesh(read_mesh(tmp_path / "model.off"), tmp_path / "out.off")
    assert (tmp_path / "out.off").read_bytes() == (tmp_path / "model.off").read_bytes()


def test_gzip_of_several_members(tmp_path: Path) -> None:
    (tmp_path / "model.off.gz").write_bytes(gzip.compress(OFF[:20]) + gzip.compress(OFF[20:]))
    assert len(read_mesh(tmp_path / "model.off.gz").vertices) == 4


@pytest.mark.parametrize("tail", [b"\n", bytes(512), b"signature"])
def test_bytes_behind_the_gzip_data_are_kept(tmp_path: Path, tail: bytes) -> None:
    path, out = tmp_path / "model.off.gz", tmp_path / "out.off.gz"
    path.write_bytes(gzip.compress(OFF, mtime=12345) + tail)
    mesh = read_mesh(path)
    assert mesh.document is not None
    assert mesh.document.remarks[0].startswith(f"{len(tail)} byte")
    write_mesh(mesh, out)
    assert out.read_bytes() == path.read_bytes()
    write_mesh(mesh.with_vertices(mesh.vertices * 2), out)
    assert out.read_bytes().endswith(tail)
    np.testing.assert_array_equal(read_mesh(out).vertices, mesh.vertices * 2)
    write_mesh(mesh, tmp_path / "out.off")
    assert (tmp_path / "out.off").read_bytes() == OFF


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (gzip.compress(OFF)[:-12], "gzip data is damaged"),
        (gzip.compress(OFF)[:40] + b"garbage" + gzip.compress(OFF)[47:], "gzip data is damaged"),
        (gzip.compress(b""), "gzip data is empty"),
        (b"", "is empty"),
        (b"\x1f\x8b", "gzip data is damaged"),
        (gzip.compress(bytes(70 << 20)), "unpacks to more than 64 MB"),
    ],
    ids=["truncated", "garbled", "empty inside", "empty", "two bytes", "bomb"],
)
def test_broken_gzip(tmp_path: Path, data: bytes, says: str) -> None:
    path = tmp_path / "model.off.gz"
    path.write_bytes(data)
    with pytest.raises(FormatError) as caught:
        read_mesh(path)
    assert says in str(caught.value)
    assert str(path) in str(caught.value)


def test_files_that_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="No such file"):
        read_mesh(tmp_path / "missing.off")
    with pytest.raises(InputError, match="is not a file"):
        read_mesh(tmp_path)
    with pytest.raises(InputError, match="cannot read"):
        read_mesh(tmp_path / "a\0b.off")
    (tmp_path / "notes.txt").write_text("just some words\n")
    with pytest.raises(InputError, match="not a model file in a known format"):
        read_mesh(tmp_path / "notes.txt")
    (tmp_path / "big.off").write_bytes(OFF)
    monkeypatch.setattr(source_module, "MOST_BYTES", 10)
    with pytest.raises(InputError, match="larger than"):
        read_mesh(tmp_path / "big.off")


def test_messages_name_the_file(tmp_path: Path) -> None:
    path = tmp_path / "model.off"
    path.write_bytes(OFF.replace(b"12.125000", b"twelve"))
    with pytest.raises(FormatError) as caught:
        read_mesh(path)
    assert str(caught.value) == f"{path}: line 5 has 'twelve' where a number is expected"


def test_meshes_of_files_are_read_only(tmp_path: Path) -> None:
    (tmp_path / "model.off").write_bytes(OFF)
    mesh = read_mesh(tmp_path / "model.off")
    assert not mesh.vertices.flags.writeable
    assert not mesh.faces.flags.writeable

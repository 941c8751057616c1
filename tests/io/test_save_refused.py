"""Where a save cannot be complete nothing is written, and nothing of others is replaced."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import InputError, OutputError
from meshmark.io import read_mesh, write_mesh
from meshmark.io import save as save_module
from meshmark.mesh import Mesh
from tests.io.saving import TETRAHEDRON, files_below


def test_the_input_is_refused_as_output(source: Path, tmp_path: Path) -> None:
    before = source.read_bytes()
    mesh = read_mesh(source)
    (tmp_path / "hard.obj").hardlink_to(source)
    (tmp_path / "soft.obj").symlink_to(source)
    (tmp_path / "sub").mkdir()
    for path in (source, tmp_path / "hard.obj", tmp_path / "soft.obj", tmp_path / "sub" / ".." / "model.obj"):
        with pytest.raises(InputError, match="is the input"):
            write_mesh(mesh, path)
    assert source.read_bytes() == before


def test_side_files_are_copied_and_never_replaced(source: Path, tmp_path: Path) -> None:
    (tmp_path / "scene.mtl").write_text("newmtl Shiny\nmap_Kd maps/skin.png\n")
    (tmp_path / "maps").mkdir()
    image = b"\x89PNG\r\n\x1a\nours"
    (tmp_path / "maps" / "skin.png").write_bytes(image)
    (tmp_path / "maps" / "skin.png").chmod(0o600)
    mesh, out = read_mesh(source), tmp_path / "out"
    out.mkdir()
    (out / "scene.mtl").write_text("theirs")
    write_mesh(mesh, out / "new.obj")
    assert files_below(out) == {
        "new.obj": source.read_bytes(),
        "scene.mtl": b"theirs",
        str(Path("maps") / "skin.png"): image,
    }
    assert (out / "maps" / "skin.png").stat().st_mode & 0o777 == 0o600
    before = files_below(tmp_path)
    write_mesh(mesh, tmp_path / "new.obj")
    assert files_below(tmp_path) == before | {"new.obj": source.read_bytes()}
    with pytest.raises(InputError, match="that the input refers to"):
        write_mesh(mesh, tmp_path / "scene.mtl")


def test_where_nothing_can_be_written(source: Path, tmp_path: Path) -> None:
    mesh = read_mesh(source)
    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "file").write_bytes(b"x")
    os.mkfifo(tmp_path / "pipe.obj")
    before = files_below(tmp_path)
    for path, says in (
        ("folder.obj", "is an existing directory"),
        ("missing/out.obj", "does not exist"),
        ("file/out.obj", "does not exist"),
        ("pipe.obj", "not an ordinary file"),
        ("a\0b.obj", "cannot write"),
        ("x" * 300 + ".obj", "cannot write"),
    ):
        with pytest.raises(OutputError) as caught:
            write_mesh(mesh, tmp_path / path)
        assert says in str(caught.value)
        assert "\n" not in str(caught.value)
    assert files_below(tmp_path) == before


@pytest.mark.parametrize("name", ["out.fbx", "out.usdz", "out.DAE", "out.blend", "out.obj.zip", "out.fbx.gz"])
def test_an_extension_that_is_not_written_is_refused(source: Path, tmp_path: Path, name: str) -> None:
    before = files_below(tmp_path)
    extension = Path(name.removesuffix(".gz")).suffix.lower()
    with pytest.raises(InputError, match=rf"'\{extension}' is not the extension of a format .*\.obj"):
        write_mesh(read_mesh(source), tmp_path / name)
    assert files_below(tmp_path) == before


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_no_space_leaves_nothing_behind(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    mesh = read_mesh(source)
    out = tmp_path / "out.obj"
    out.write_bytes(b"older")
    before = files_below(tmp_path)
    monkeypatch.setattr(*((save_module.os, "fsync", fail) if step == "fsync" else (Path, "replace", fail)))
    with pytest.raises(OutputError, match="No space left on device"):
        write_mesh(mesh, out)
    assert files_below(tmp_path) == before


def test_a_real_limit_on_file_size(tmp_path: Path) -> None:
    script = (
        "import resource, sys, numpy as np\nfrom meshmark.mesh import Mesh\nfrom meshmark.io import write_mesh\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))\n"
        "mesh = Mesh(np.random.default_rng(0).random((900, 3)), np.arange(900).reshape(-1, 3))\n"
        "try:\n    write_mesh(mesh, sys.argv[1])\n"
        "except Exception as error:\n    print(type(error).__name__, error)\n"
    )
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 5000
    result = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "out.obj")],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert result.stdout.startswith("OutputError cannot write")
    assert files_below(tmp_path) == {}


def test_a_link_is_followed(source: Path, tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link.obj").symlink_to(tmp_path / "real" / "there.obj")
    write_mesh(read_mesh(source), tmp_path / "link.obj")
    assert (tmp_path / "link.obj").is_symlink()
    assert (tmp_path / "real" / "there.obj").read_bytes() == source.read_bytes()


def test_external_buffers_of_the_input_are_never_replaced(tmp_path: Path) -> None:
    write_mesh(TETRAHEDRON, tmp_path / "made.glb")
    before = files_below(tmp_path)
    mesh = read_mesh(tmp_path / "made.glb")
    document = mesh.document
    assert document is not None

    class TwoFiles:
        """A document whose save writes a second file under a fixed name."""

        def __getattr__(self, name: str) -> object:
            return getattr(document.document, name)  # type: ignore[union-attr]

        def patched(self, vertices: np.ndarray, name: str) -> dict[str, bytes]:
            return {name: b"main", "shared.bin": b"second"}

    two = save_module.SourceFile(path=tmp_path / "made.glb", document=TwoFiles())  # type: ignore[arg-type]
    pair = Mesh(mesh.vertices, mesh.faces, two)
    (tmp_path / "shared.bin").write_bytes(b"the input's")
    with pytest.raises(InputError, match=r"would replace shared\.bin"):
        write_mesh(pair, tmp_path / "out.glb")
    assert files_below(tmp_path) == before | {"shared.bin": b"the input's"}
    (tmp_path / "elsewhere").mkdir()
    report = write_mesh(pair, tmp_path / "elsewhere" / "out.glb")
    assert [file.name for file in report.files] == ["out.glb", "shared.bin"]

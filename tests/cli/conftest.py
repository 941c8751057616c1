"""The program run in this process, and one marked model for all tests of it."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from meshmark.cli.main import main
from meshmark.coding.keys import Key
from meshmark.io import write_mesh
from meshmark.mesh import FloatArray, IntArray, Mesh
from tests.keys import IDENTITY
from tests.shapes import pebble


class Ran(NamedTuple):
    """What a command line gave."""

    code: int
    out: str
    err: str
    as_json: bool = False


Run = Callable[..., Ran]


@pytest.fixture(autouse=True)
def drawn_as_drafts(drafts: None) -> None:
    """Draw all pictures as drafts."""


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run one command line: `cli("info", path)`."""

    def run(*arguments: object) -> Ran:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        return Ran(code, *capsys.readouterr(), as_json="--json" in arguments)

    return run


@pytest.fixture
def small_model(tmp_path: Path) -> Path:
    """A model of 762 vertices."""
    write_mesh(Mesh(*pebble(40)), tmp_path / "small.ply")
    return tmp_path / "small.ply"


class Files(NamedTuple):
    """A model of so many vertices and faces, a key, and the model marked with `IDENTITY`."""

    model: Path
    key: Path
    marked: Path
    printed: dict[str, object]
    vertices: int
    faces: int


def coloured_ply(points: FloatArray, faces: IntArray) -> bytes:
    """Return a binary PLY file of single floats with a colour for each vertex."""
    vertices = np.zeros(len(points), [("xyz", "<f4", 3), ("rgb", "u1", 3)])
    vertices["xyz"] = points
    vertices["rgb"] = np.clip(100.0 + 40.0 * points, 0.0, 255.0)
    triangles = np.full(len(faces), 3, [("count", "u1"), ("corners", "<i4", 3)])
    triangles["corners"] = faces
    header = [
        "ply", "format binary_little_endian 1.0", "comment a pebble",
        f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz"),
        *(f"property uchar {colour}" for colour in ("red", "green", "blue")),
        f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", "",
    ]  # fmt: skip
    return "\n".join(header).encode() + vertices.tobytes() + triangles.tobytes()


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """Return files that tests only read."""
    import contextlib
    import io
    import json

    folder = tmp_path_factory.mktemp("files")
    points, faces = pebble(66)
    model = folder / "pebble.ply.gz"
    model.write_bytes(gzip.compress(coloured_ply(points, faces), mtime=0))
    found = Files(model, folder / "owner.key", folder / "marked.ply", {}, len(points), len(faces))
    Key(bytes(range(32))).save(found.key)
    captured = io.StringIO()
    with contextlib.redirect_stdout(captured):
        code = main(
            [
                "embed",
                str(found.model),
                str(found.marked),
                "--key",
                str(found.key),
                "--id",
                IDENTITY,
                "--json",
            ]
        )
    assert code == 0
    return found._replace(printed=json.loads(captured.getvalue()))

"""The program run in this process, and one marked model for all tests of it."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from meshmark.cli.main import main
from meshmark.coding.keys import Key
from meshmark.data import hare_ply
from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from tests.shapes import pebble

IDENTITY = "0123456789abcdef"


class Ran(NamedTuple):
    """What a command line gave."""

    code: int
    out: str
    err: str
    as_json: bool = False


Run = Callable[..., Ran]


@pytest.fixture(autouse=True, scope="session")
def drafts() -> Iterator[None]:
    """Draw pictures with one sample for each pixel; smooth edges are what tests/report looks at."""
    from meshmark.report import picture

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(picture, "FINER", 1)
        yield


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
    """A model of 1,106 vertices."""
    write_mesh(Mesh(*pebble(48)), tmp_path / "small.ply")
    return tmp_path / "small.ply"


class Files(NamedTuple):
    """A model, a key, and the model marked with `IDENTITY`."""

    model: Path
    key: Path
    marked: Path
    printed: dict[str, object]


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """Return files that tests only read."""
    import contextlib
    import io
    import json

    folder = tmp_path_factory.mktemp("files")
    (folder / "hare.ply.gz").write_bytes(gzip.compress(hare_ply(), mtime=0))
    found = Files(folder / "hare.ply.gz", folder / "owner.key", folder / "marked.ply", {})
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

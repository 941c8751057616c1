"""A folder of small models, and a package outside meshmark that registers schemes."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from meshmark.benchmark.shapes import lopsided
from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from tests.benchmark import toy_schemes

NAMES = ("Toy", "Crashing", "Hanging", "Hungry", "Broken", "Short", "Informed")


@pytest.fixture(scope="session")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for PYTHONPATH in which a package is installed that registers the toy schemes."""
    folder = tmp_path_factory.mktemp("site-packages")
    shutil.copy(toy_schemes.__file__, folder / "toy_schemes_of_elsewhere.py")
    info = folder / "toy_schemes-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-schemes\nVersion: 1.0\n")
    points = "".join(f"{name.lower()} = toy_schemes_of_elsewhere:{name}\n" for name in NAMES)
    (info / "entry_points.txt").write_text(f"[meshmark.schemes]\n{points}")
    return folder


@pytest.fixture
def toys(outside: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process and its children find the toy schemes."""
    monkeypatch.syspath_prepend(str(outside))
    monkeypatch.setenv("PYTHONPATH", str(outside))


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with three models: 614 vertices, 313 (an odd number), and 14, too few for the toy."""
    folder = tmp_path_factory.mktemp("models")
    (folder / "train").mkdir()
    (folder / "test" / "deep").mkdir(parents=True)
    even, tiny = lopsided(36), lopsided(6)
    odd = lopsided(26)
    kept = ~(odd.faces == len(odd.vertices) - 1).any(axis=1)
    write_mesh(even, folder / "train" / "even.ply")
    write_mesh(Mesh(odd.vertices[:-1], odd.faces[kept]), folder / "test" / "deep" / "odd.off")
    write_mesh(tiny, folder / "tiny.obj")
    return folder

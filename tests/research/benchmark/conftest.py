"""A folder of small models, and a package outside meshmark that registers schemes."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from meshmark.research.benchmark.run.run import Finished, Plan, run
from meshmark.research.benchmark.run.sample_shape import lopsided
from tests.research.benchmark.runs import install

NAMES = ("Toy", "Crashing", "Hanging", "Hungry", "Broken", "Short", "Informed", "Sorting")


@pytest.fixture(scope="session")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for PYTHONPATH in which a package is installed that registers the toy schemes."""
    folder = tmp_path_factory.mktemp("site-packages")
    install(folder, NAMES)
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


@pytest.fixture(scope="session")
def whole(models: Path, outside: Path, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """An uninterrupted run of the toy on these models, with one worker."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(outside))
        patch.setenv("PYTHONPATH", str(outside))
        return run(
            Plan(
                suite="smoke", data=models, out=tmp_path_factory.mktemp("whole"), schemes=("toy",), workers=1
            )
        )

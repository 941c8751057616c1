"""One server for all tests that need a running one, a model, and the model marked by it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from meshmark.coding.keys import Key
from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from meshmark.registry.registry import Registry
from tests.shapes import pebble
from tests.web.server.served import Served, serving

# Always the same ones, for which marking the models of these tests takes little time.
KEY, IDENTITY = Key(bytes(32)), f"{5:016x}"


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server with one key, studio."""
    with serving(tmp_path_factory.mktemp("server")) as served:
        KEY.save(served.key)
        yield served


@pytest.fixture(scope="session")
def registry_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server with a registry, bound to more than this computer, with the same key."""
    folder = tmp_path_factory.mktemp("registry")
    Registry.create(folder / "copies.db")[0].database.close()
    with serving(folder, "--host", "0.0.0.0", "--registry", str(folder / "copies.db")) as served:
        KEY.save(served.key)
        yield served


@pytest.fixture(scope="session")
def pebble_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of 1,514 vertices."""
    path = tmp_path_factory.mktemp("model") / "pebble.ply"
    write_mesh(Mesh(*pebble(56)), path)
    return path


@pytest.fixture(scope="session")
def marked_job(server: Served, pebble_file: Path) -> dict[str, Any]:
    """The job that marked the model."""
    return server.run("embed", pebble_file, id=IDENTITY)


@pytest.fixture(scope="session")
def marked_file(server: Served, marked_job: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The marked model, downloaded."""
    return server.save(marked_job, "model", tmp_path_factory.mktemp("marked"))

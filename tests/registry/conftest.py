"""Registries to test with: an SQLite file, and a database of a real PostgreSQL server where there is one."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest

from meshmark.registry.registry import Registry
from tests.registry.postgres import server, why_not

_NUMBERS = count()


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    """Return the address of a running server."""
    if reason := why_not():
        pytest.skip(reason)
    with server() as address:
        yield address


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Return the place of a registry of which nothing is there yet, of either kind."""
    if request.param == "sqlite":
        yield str(tmp_path / "issued.db")
        return
    import psycopg

    address = request.getfixturevalue("postgres")
    name = f"test_{next(_NUMBERS)}"
    with psycopg.connect(address, autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name}")
    yield address.replace("/postgres?", f"/{name}?")
    with psycopg.connect(address, autocommit=True) as connection:
        connection.execute(f"DROP DATABASE {name} WITH (FORCE)")


@pytest.fixture
def registry(place: str) -> Iterator[Registry]:
    """Return an empty registry of either kind."""
    made, changed = Registry.create(place)
    assert changed
    with made:
        yield made

"""The database of a registry: an SQLite file, or PostgreSQL by its address.

    a path, or sqlite:///a/path           SQLite, with write-ahead logging: nobody waits for a reader
    postgresql://user:password@host/name  PostgreSQL, with the extra `postgres`

Passwords are in no message. A transaction that writes takes SQLite's one place for writers when it begins, so that
it waits for another one instead of failing half way.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, IntegrityError, SQLAlchemyError

from meshmark.errors import RegistryError

__all__ = ["Database"]

WAIT: Final = 60.0
"""Seconds that a writer waits for the others of an SQLite file."""
_EXPECTED = "expected a path, sqlite:///PATH or postgresql://USER:PASSWORD@HOST/NAME"
_WRITES = "meshmark_writes"


@dataclass(frozen=True)
class Database:
    """Where a registry lies; nothing is opened before it is used."""

    place: str

    @cached_property
    def url(self) -> URL:
        """The address; raises `RegistryError` where it is none."""
        if "://" not in self.place:
            if not self.place:
                raise RegistryError(f"the place of the registry is empty, {_EXPECTED}")
            return URL.create("sqlite+pysqlite", database=self.place)
        try:
            url = make_url(self.place)
        except (ArgumentError, ValueError):
            raise RegistryError(f"the address of the registry cannot be read, {_EXPECTED}") from None
        if url.drivername == "sqlite" and url.database:
            return url.set(drivername="sqlite+pysqlite")
        if url.drivername in ("postgresql", "postgres", "postgresql+psycopg"):
            return url.set(drivername="postgresql+psycopg")
        raise RegistryError(f"{url.set(query={}).render_as_string()} is no place of a registry, {_EXPECTED}")

    @property
    def path(self) -> Path | None:
        """The file of an SQLite database, None of PostgreSQL."""
        return Path(str(self.url.database)) if self.url.get_backend_name() == "sqlite" else None

    @property
    def shown(self) -> str:
        """What messages call it: the path, or the address without the password."""
        if self.path is not None:
            return str(self.path)
        # A password may be in the query, too.
        return self.url.set(drivername="postgresql", query={}).render_as_string(hide_password=True)

    @cached_property
    def engine(self) -> Engine:
        """What makes connections; raises `RegistryError` where the driver of PostgreSQL is missing."""
        try:
            if self.path is not None:
                engine = create_engine(self.url, connect_args={"timeout": WAIT})
                event.listen(engine, "connect", _prepare_sqlite)
                event.listen(engine, "begin", _begin_sqlite)
                return engine
            return create_engine(self.url, pool_pre_ping=True, pool_size=1)
        except ModuleNotFoundError:
            raise RegistryError(
                "a registry on PostgreSQL needs the driver psycopg, get it with: pip install meshmark[postgres]"
            ) from None

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Read in one transaction; raises `RegistryError` where the database fails."""
        with self._transaction(writes=False) as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Write in one transaction, all of it or nothing; raises `RegistryError` where the database fails.

        `sqlalchemy.exc.IntegrityError` passes: two rows of one id are for the caller to tell of.
        """
        with self._transaction(writes=True) as connection:
            yield connection

    @contextmanager
    def _transaction(self, *, writes: bool) -> Iterator[Connection]:
        try:
            with self.engine.connect() as connection:
                connection.execution_options(**{_WRITES: writes})
                with connection.begin():
                    yield connection
        except IntegrityError:
            raise
        except SQLAlchemyError as error:
            raise self.failure(error, "write to" if writes else "read") from None

    def failure(self, error: SQLAlchemyError, verb: Literal["read", "write to", "open"]) -> RegistryError:
        """Return what to say of an error of the database, in one sentence and without the address's password."""
        reason = str(error.orig) if isinstance(error, DBAPIError) else str(error)
        reason = " ".join(reason.split()) or type(error).__name__
        if self.url.password:
            reason = reason.replace(str(self.url.password), "***")
        return RegistryError(f"cannot {verb} the registry {self.shown}: {reason}", file=self.file)

    @property
    def file(self) -> str | None:
        """Name of the file, for errors."""
        return None if self.path is None else str(self.path)

    def close(self) -> None:
        """Close all connections."""
        if "engine" in self.__dict__:
            self.engine.dispose()


def _prepare_sqlite(connection: sqlite3.Connection, _record: Any) -> None:
    """Leave transactions to us, keep what refers to what, and answer only when the disk has it."""
    connection.isolation_level = None
    cursor = connection.cursor()
    for setting in ("foreign_keys = ON", "synchronous = FULL"):
        cursor.execute(f"PRAGMA {setting}")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get(_WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

"""The tables of a registry: made, brought up to date, and checked before they are used."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from sqlalchemy import Connection, inspect, text
from sqlalchemy.exc import SQLAlchemyError

from meshmark.errors import RegistryError
from meshmark.registry.database_tables import REVISION

if TYPE_CHECKING:
    from alembic.script import ScriptDirectory

    from meshmark.registry.connection import Database

__all__ = ["check_tables", "make_tables"]

_VERSIONS = "alembic_version"
# Two programs that make the tables of one PostgreSQL database at once wait for each other under this number.
_LOCK = 0x6D657368


def make_tables(database: Database) -> bool:
    """Make the tables of a registry, or bring those of an earlier version up to date; what they hold stays.

    Returns whether there was anything to do. Raises `RegistryError` where the database cannot be written, or holds
    tables of a later version.
    """
    from alembic.operations import Operations
    from alembic.runtime.migration import MigrationContext

    if (path := database.path) is not None:
        if not path.parent.is_dir():
            raise RegistryError(
                f"cannot make the registry {path}: the folder {path.parent} does not exist", file=path
            )
        try:
            os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))  # names of customers are its owner's alone
        except OSError as error:
            raise RegistryError(f"cannot make the registry {path}: {error.strerror}", file=path) from None
        try:
            with database.engine.connect() as connection:
                raw = connection.connection.driver_connection
                raw.execute("PRAGMA journal_mode = WAL")  # type: ignore[union-attr]
        except SQLAlchemyError as error:
            raise database.failure(error, "open") from None
        except Exception as error:  # sqlite3's own
            raise RegistryError(f"cannot open the registry {path}: {error}", file=path) from None
    script = _scripts()
    with database.writing() as connection:
        if path is None:
            connection.execute(text("SELECT pg_advisory_xact_lock(:number)"), {"number": _LOCK})
        found = _revision(connection)
        if found is not None and found not in {each.revision for each in script.walk_revisions()}:
            raise _later(database, found)
        missing = list(script.iterate_revisions("head", found or "base"))
        context = MigrationContext.configure(connection)
        with Operations.context(context):
            for revision in reversed(missing):
                revision.module.upgrade()
        if missing:
            context.stamp(script, "head")
    return bool(missing)


def check_tables(database: Database) -> None:
    """Raise `RegistryError` where a database has no tables of a registry, or those of another version."""
    if database.path is not None and not database.path.exists():
        raise RegistryError(
            f"there is no registry at {database.shown}, `meshmark registry init` makes one",
            file=database.path,
        )
    with database.reading() as connection:
        found = _revision(connection)
    if found is None:
        raise RegistryError(
            f"{database.shown} holds no registry, `meshmark registry init` makes one", file=database.path
        )
    if found < REVISION:
        raise RegistryError(
            f"the registry {database.shown} is of an earlier version ({found}, expected {REVISION}), "
            "`meshmark registry init` brings it up to date",
            file=database.path,
        )
    if found > REVISION:
        raise _later(database, found)


def _later(database: Database, found: str) -> RegistryError:
    return RegistryError(
        f"the registry {database.shown} is of a later version ({found}, expected {REVISION}), update meshmark",
        file=database.path,
    )


def _revision(connection: Connection) -> str | None:
    """Return at which migration a database is, None where it holds no registry."""
    if not inspect(connection).has_table(_VERSIONS):
        return None
    return connection.execute(text(f"SELECT version_num FROM {_VERSIONS}")).scalar()


def _scripts() -> ScriptDirectory:
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", "meshmark.registry:migrations")
    config.set_main_option("path_separator", "os")
    return ScriptDirectory.from_config(config)

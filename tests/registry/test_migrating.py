"""The tables of a registry: what the migrations make is what the program expects."""

from __future__ import annotations

import pytest
from sqlalchemy import text
from sqlalchemy.exc import IntegrityError

from meshmark.errors import RegistryError
from meshmark.registry.connection import Database
from meshmark.registry.database_tables import METADATA, REVISION
from meshmark.registry.migrating import make_tables
from meshmark.registry.registry import Registry


def test_the_migrations_make_the_tables_that_the_program_knows(registry):
    from alembic.autogenerate import compare_metadata
    from alembic.runtime.migration import MigrationContext

    with registry.database.reading() as connection:
        context = MigrationContext.configure(connection)
        assert context.get_current_revision() == REVISION
        assert compare_metadata(context, METADATA) == []


def test_the_tables_go_as_they_came(registry):
    from alembic.operations import Operations
    from alembic.runtime.migration import MigrationContext

    from meshmark.registry.migrations.versions import first_tables

    with registry.database.writing() as connection:
        with Operations.context(MigrationContext.configure(connection)):
            first_tables.downgrade()
        connection.execute(text("DELETE FROM alembic_version"))
    assert make_tables(registry.database)
    assert registry.copies() == []


@pytest.mark.parametrize(
    ("revision", "message"),
    [
        ("0000", r"is of an earlier version \(0000, expected 0001\), `meshmark registry init`"),
        ("0002", r"is of a later version \(0002, expected 0001\), update meshmark"),
    ],
)
def test_a_registry_of_another_version_is_refused(registry, place, revision, message):
    with registry.database.writing() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :new"), {"new": revision})
    with pytest.raises(RegistryError, match=message):
        Registry.open(place)


def test_tables_of_a_later_version_are_left_alone(registry, place):
    with registry.database.writing() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '0002'"))
    with pytest.raises(RegistryError, match="update meshmark"):
        Registry.create(place)


def test_a_database_without_tables_is_no_registry(place):
    if (path := Database(place).path) is not None:
        path.touch()
    with pytest.raises(RegistryError, match="holds no registry, `meshmark registry init` makes one"):
        Registry.open(place)


def test_what_refers_to_nothing_is_refused(registry):
    """Foreign keys hold, which SQLite does only where it is told to."""
    from meshmark.registry.database_tables import copies

    with pytest.raises(IntegrityError), registry.database.writing() as connection:
        connection.execute(
            copies.insert().values(id="0" * 16, key="0" * 16, original_row=99, state="pending")
        )


def test_a_transaction_that_fails_leaves_nothing(registry):
    from meshmark.registry.database_tables import originals

    row = originals.insert().values(digest="0" * 64, name="a", points=1, registered_at="2026-11-29T12:00:00Z")

    def fail() -> None:
        with registry.database.writing() as connection:
            connection.execute(row)
            connection.execute(text("SELECT nonsense FROM nowhere"))

    with pytest.raises(RegistryError, match="cannot write to the registry"):
        fail()
    assert registry.originals() == []

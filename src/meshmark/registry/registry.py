"""A registry: what was issued, to whom, when, of which original.

    with Registry.open("issued.db") as registry:
        registry.copies_with_id(0x0123456789ABCDEF)

A copy is entered in three steps, each a transaction of its own: `reserve` holds an id before anything is computed,
`complete` enters what was made when the file is whole under its temporary name, `confirm` says that it took its
name. After a crash a row may stay pending; no file has a name without a complete row.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from sqlalchemy import Connection, exists, func, select, update
from sqlalchemy.exc import IntegrityError

from meshmark.coding.message import format_id, parse_id, random_id
from meshmark.errors import RegistryError
from meshmark.registry.connection import Database
from meshmark.registry.database_tables import ISSUED, PENDING, copies, originals
from meshmark.registry.importing import Incoming
from meshmark.registry.migrating import check_tables, make_tables
from meshmark.registry.records import Copy, Original
from meshmark.registry.rows import copy_of, copy_query, copy_values, original_of, plain, row_of, same_copy

__all__ = ["Registry"]

# The chance that two of 2^20 random ids are equal is 3e-8; more draws than this are none.
_DRAWS = 8


class Registry:
    """An open registry; use as a context manager, in one process."""

    def __init__(self, database: Database) -> None:
        """Use the database as it is; `open` checks its tables, `create` makes them."""
        self.database = database

    @classmethod
    def open(cls, place: str | os.PathLike[str]) -> Self:
        """Open a registry.

        place: path of an SQLite file, sqlite:///PATH, or postgresql://USER:PASSWORD@HOST/NAME.
        Raises `RegistryError` where there is none.
        """
        database = Database(os.fspath(place))
        with _closed_where_it_fails(database):
            check_tables(database)
        return cls(database)

    @classmethod
    def create(cls, place: str | os.PathLike[str]) -> tuple[Self, bool]:
        """Open a registry after making its tables or bringing them up to date; what they hold stays.

        Returns it, and whether there was anything to do. Raises `RegistryError` where that fails.
        """
        database = Database(os.fspath(place))
        with _closed_where_it_fails(database):
            changed = make_tables(database)
        return cls(database), changed

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.database.close()

    def reserve(
        self,
        original: Original,
        key: str,
        *,
        id: int | None = None,
        bits: int = 64,
        recipient: str | None = None,
        path: str | None = None,
    ) -> int:
        """Hold an id for a copy of an original, and return it.

        A copy of the same original, recipient, path and id that was left pending is taken over.

        Parameters
        ----------
        original : Original
            Entered where it is new.
        key : str
            Public fingerprint of the key.
        id, bits : int, optional
            Drawn where it is left out, of 64 or 32 bits, another than all of this key.
        recipient, path : str, optional
            To whom the copy goes, and where its file.

        Returns
        -------
        int

        Raises
        ------
        RegistryError
            The id is another copy's already, or the registry cannot be written.
        """
        values = {"key": key, "recipient": plain(recipient), "path": plain(path), "state": PENDING}
        for _ in range(_DRAWS):
            wanted = format_id(random_id(bits) if id is None else id)
            try:
                with self.database.writing() as connection:
                    row = row_of(connection, original)
                    if id is not None and _is_pending(
                        connection, {**values, "id": wanted, "original_row": row}
                    ):
                        return id
                    connection.execute(copies.insert().values(**values, id=wanted, original_row=row))
                return parse_id(wanted)
            except IntegrityError:
                if id is not None:
                    raise self.taken(id, key) from None
        raise RegistryError(f"the registry {self.database.shown} has no free id, expected one of 2^{bits}")

    def complete(self, copy: Copy, certificate: str) -> None:
        """Enter how a copy was made, before its file takes its name.

        copy: its id, key, mark, versions, time and digests; certificate: the text of the file.
        Raises `RegistryError` where the id is not held.
        """
        held = ("id", "key", "recipient", "path", "state")
        made = {name: value for name, value in copy_values(copy).items() if name not in held}
        self._change(copy.id, copy.key, PENDING, {**made, "certificate": certificate})

    def confirm(self, id: int, key: str) -> None:
        """Say that the file of a copy has its name; raises `RegistryError` where it was not entered."""
        self._change(id, key, PENDING, {"state": ISSUED})

    def relocate(self, id: int, key: str, path: str) -> None:
        """Say what the file of an issued copy is called now; raises `RegistryError` where there is no such copy."""
        self._change(id, key, ISSUED, {"path": plain(path)})

    def withdraw(self, id: int, key: str) -> None:
        """Give up an id that is held for a copy of which no file came to be."""
        with self.database.writing() as connection:
            connection.execute(
                copies.delete().where(
                    copies.c.id == format_id(id), copies.c.key == key, copies.c.state == PENDING
                )
            )

    def add(self, things: Iterable[Incoming]) -> tuple[int, int]:
        """Enter copies that were made elsewhere, all of them or none.

        Returns how many are new, and how many were there.
        Raises `RegistryError` where an id is that of another copy.
        """
        new = there = 0
        with self.database.writing() as connection:
            for each in things:
                row = row_of(connection, each.original)
                query = copy_query().where(
                    copies.c.id == format_id(each.copy.id), copies.c.key == each.copy.key
                )
                known = connection.execute(query).first()
                if known is None:
                    values = {**copy_values(each.copy), "certificate": each.certificate, "original_row": row}
                    connection.execute(copies.insert().values(**values))
                    new += 1
                elif same_copy(copy_of(known), each.copy):
                    there += 1
                else:
                    raise RegistryError(
                        f"the id {format_id(each.copy.id)} is in the registry already as another copy, and nothing "
                        "was imported"
                    )
        return new, there

    def copies_with_id(self, id: int, key: str | None = None) -> list[Copy]:
        """Return the copies with an id: of one key at most one, of all keys (None) more by chance only."""
        query = copy_query().where(copies.c.id == format_id(id))
        if key is not None:
            query = query.where(copies.c.key == key)
        with self.database.reading() as connection:
            return [copy_of(row) for row in connection.execute(query.order_by(copies.c.row))]

    def recipients(self, ids: Iterable[int], key: str) -> list[str | None]:
        """Return to whom the copies with these ids went, None for those of which that was not said."""
        return [copy.recipient for each in ids for copy in self.copies_with_id(each, key)]

    def copies(
        self, *, original: str | None = None, key: str | None = None, recipient: str | None = None
    ) -> list[Copy]:
        """Return the copies in the order in which their ids were held.

        original (digest), key (fingerprint), recipient: those of it alone.
        """
        query = copy_query()
        for column, value in (
            (originals.c.digest, original),
            (copies.c.key, key),
            (copies.c.recipient, recipient),
        ):
            if value is not None:
                query = query.where(column == value)
        with self.database.reading() as connection:
            return [copy_of(row) for row in connection.execute(query.order_by(copies.c.row))]

    def certificate(self, id: int, key: str) -> str | None:
        """Return the text of the certificate of a copy, None where there is none."""
        query = select(copies.c.certificate).where(copies.c.id == format_id(id), copies.c.key == key)
        with self.database.reading() as connection:
            return connection.execute(query).scalar()

    def originals(self) -> list[Original]:
        """Return all originals, in the order in which they came in."""
        with self.database.reading() as connection:
            rows = connection.execute(select(originals).order_by(originals.c.row))
            return [original_of(row) for row in rows]

    def original(self, digest: str) -> Original | None:
        """Return an original by its digest, None where it is not there."""
        with self.database.reading() as connection:
            row = connection.execute(select(originals).where(originals.c.digest == digest)).first()
        return None if row is None else original_of(row)

    def shapes(self, key: str) -> list[tuple[str, str, bytes | None]]:
        """Return (digest, name, descriptor) of the originals with copies of a key."""
        marked = exists().where(copies.c.original_row == originals.c.row, copies.c.key == key)
        query = select(originals.c.digest, originals.c.name, originals.c.descriptor).where(marked)
        with self.database.reading() as connection:
            return [tuple(row) for row in connection.execute(query.order_by(originals.c.row))]

    def ids(self, original: str, key: str) -> tuple[int, ...]:
        """Return the ids of the copies of an original, also those that are pending, in order."""
        query = (
            select(copies.c.id)
            .join_from(copies, originals)
            .where(originals.c.digest == original, copies.c.key == key)
            .order_by(copies.c.row)
        )
        with self.database.reading() as connection:
            return tuple(parse_id(each) for each in connection.execute(query).scalars())

    def typical_certificates(self, original: str, key: str, most: int) -> list[str]:
        """Return one certificate for each of the commonest ways in which copies of an original are marked."""
        ways = [copies.c[name] for name in ("carriers", "lattice", "spacing", "step")]
        first, count = func.min(copies.c.row), func.count()
        grouped = (
            select(first)
            .join_from(copies, originals)
            .where(originals.c.digest == original, copies.c.key == key, copies.c.lattice.is_not(None))
            .group_by(*ways)
            .order_by(count.desc(), first)
            .limit(most)
        )
        with self.database.reading() as connection:
            rows = connection.execute(grouped).scalars().all()
            found = (select(copies.c.certificate).where(copies.c.row == row) for row in rows)
            return [text for query in found if (text := connection.execute(query).scalar()) is not None]

    def taken(self, id: int, key: str) -> RegistryError:
        """Return what to say where a new copy is to have the id of another one."""
        found = self.copies_with_id(id, key)
        to = f" to {found[0].recipient}" if found and found[0].recipient else ""
        whose = f" ({found[0].state}{to}, a copy of {found[0].original_name})" if found else ""
        return RegistryError(
            f"the id {format_id(id)} is in the registry already{whose}, expected a new one for each copy"
        )

    def _change(self, id: int, key: str, state: str, values: dict[str, object]) -> None:
        query = update(copies).where(
            copies.c.id == format_id(id), copies.c.key == key, copies.c.state == state
        )
        with self.database.writing() as connection:
            if connection.execute(query.values(**values)).rowcount != 1:
                raise RegistryError(
                    f"the registry {self.database.shown} no longer holds the id {format_id(id)} as {state}"
                )


@contextmanager
def _closed_where_it_fails(database: Database) -> Iterator[None]:
    try:
        yield
    except BaseException:
        database.close()
        raise


def _is_pending(connection: Connection, values: dict[str, object]) -> bool:
    """Return whether the very copy is held already."""
    query = select(copies.c.row)
    for name, value in values.items():
        query = query.where(copies.c[name].is_(None) if value is None else copies.c[name] == value)
    return connection.execute(query).first() is not None

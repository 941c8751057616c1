"""Between rows of the tables and the values of `records`."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from sqlalchemy import Connection, Row, Select, select
from sqlalchemy.dialects import postgresql, sqlite

from meshmark.coding.message import format_id, parse_id
from meshmark.errors import InputError
from meshmark.registry.database_tables import copies, originals
from meshmark.registry.records import Copy, MarkedWith, Original

__all__ = ["copy_of", "copy_query", "copy_values", "original_of", "plain", "row_of", "same_copy"]

_MARK = ("strength", "layers", "carriers", "lattice", "spacing", "step")
# Columns of a copy that mean in a row what they mean in a record.
_SAME = (
    "key",
    "recipient",
    "path",
    "state",
    "mark_format",
    "meshmark",
    "issued_at",
    "marked_digest",
    "commitment",
)


def copy_query() -> Select[Any]:
    """Return the query for all copies with their originals, without certificates."""
    columns = [copies.c[name] for name in ("id", *_SAME, *_MARK)]
    return select(*columns, originals.c.digest, originals.c.name).join_from(copies, originals)


def copy_of(row: Row[Any]) -> Copy:
    """Return the copy of a row of `copy_query`."""
    values = row._mapping
    mark = None if values["lattice"] is None else MarkedWith(**{name: values[name] for name in _MARK})
    return Copy(
        id=parse_id(values["id"]),
        original=values["digest"],
        original_name=values["name"],
        mark=mark,
        **{name: values[name] for name in _SAME},
    )


def copy_values(copy: Copy) -> dict[str, Any]:
    """Return the columns of a copy, without its original and its certificate."""
    mark = dict.fromkeys(_MARK) if copy.mark is None else asdict(copy.mark)
    same = {name: getattr(copy, name) for name in _SAME}
    same |= {name: plain(same[name]) for name in ("recipient", "path")}
    return {"id": format_id(copy.id), **same, **mark}


def original_of(row: Row[Any]) -> Original:
    """Return the original of a row of its table."""
    return Original(**{name: value for name, value in row._mapping.items() if name != "row"})


def row_of(connection: Connection, original: Original) -> int:
    """Return the row of an original, entered where it is new, in this transaction."""
    insert = postgresql.insert if connection.dialect.name == "postgresql" else sqlite.insert
    values = {**asdict(original), "name": plain(original.name)}
    connection.execute(insert(originals).values(**values).on_conflict_do_nothing(index_elements=["digest"]))
    query = select(originals.c.row).where(originals.c.digest == original.digest)
    return int(connection.execute(query).scalar_one())


def same_copy(one: Copy, other: Copy) -> bool:
    """Return whether two records are of one copy: equal, whatever the original is called."""
    return replace(one, original_name="") == replace(other, original_name="")


def plain(text: str | None) -> str | None:
    """Return text as every database can hold it; raises `InputError` for what none should.

    Bytes of a file name that are no characters are written as escapes.
    """
    if text is None:
        return None
    if "\0" in text:
        raise InputError(f"{text!r} holds a zero character, expected text")
    return text.encode("utf-8", "backslashreplace").decode()

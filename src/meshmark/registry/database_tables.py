"""The tables of a registry, as SQLAlchemy Core knows them; `migrations` makes them in a database.

    originals    a model that copies were made of
      digest        SHA-256 of its positions and faces, 64 hexadecimal digits (`original_digest`)
      name          of its file, without the folder
      points        different ones
      descriptor    of its shape (`shape_descriptor`), NULL where it is not known
      registered_at UTC, as all times are: "2026-11-29T13:40:00Z"
    copies       a marked copy, or an id that is held for one
      id, key       16 hexadecimal digits of the id, or 8 of one of 32 bits, and 16 of the public fingerprint of
                    the key: unique together
      original_row  row of its original
      recipient     to whom it went, NULL where that was not said
      path          where the file was written
      state         "pending" until the file has its name, then "issued"
      strength, layers, carriers, lattice, spacing, step     of the mark
      mark_format, meshmark                    version of the marks and of the program
      issued_at, marked_digest, commitment     time, SHA-256 of the file, `commitment`
      certificate   the certificate's file; pending rows have these four once the file is complete

Keys are never stored: only their public fingerprints.
"""

from __future__ import annotations

from typing import Final

from sqlalchemy import (
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)

__all__ = ["ISSUED", "METADATA", "PENDING", "REVISION", "copies", "originals"]

REVISION: Final = "0001"
"""The newest of the migrations: what a registry must be at to be read."""
PENDING: Final = "pending"
ISSUED: Final = "issued"
"""The states of a copy."""

METADATA = MetaData()

originals = Table(
    "originals",
    METADATA,
    Column("row", Integer, primary_key=True),
    Column("digest", String(64), nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("points", Integer, nullable=False),
    Column("registered_at", String(20), nullable=False),
    Column("descriptor", LargeBinary),
)

copies = Table(
    "copies",
    METADATA,
    Column("row", Integer, primary_key=True),
    Column("id", String(16), nullable=False),
    Column("key", String(16), nullable=False),
    Column("original_row", Integer, ForeignKey("originals.row"), nullable=False),
    Column("recipient", Text),
    Column("path", Text),
    Column("state", String(8), nullable=False),
    Column("strength", String(16)),
    Column("layers", String(16)),
    Column("carriers", String(8)),
    Column("lattice", String(32)),
    Column("spacing", Float),
    Column("step", Float),
    Column("mark_format", Integer),
    Column("meshmark", String(32)),
    Column("issued_at", String(20)),
    Column("marked_digest", String(64)),
    Column("commitment", String(64)),
    Column("certificate", Text),
    UniqueConstraint("id", "key", name="one_copy_for_each_id"),
    Index("copies_of_an_original", "original_row", "key"),
    Index("copies_of_a_recipient", "recipient"),
)

"""The row of a copy, from the id that is held for it to the file in its place."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from meshmark import __version__
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import VERSION
from meshmark.coding.keys import Key
from meshmark.coding.message import format_id
from meshmark.errors import RegistryError
from meshmark.io.file_digest import digest_of_file
from meshmark.marking.embedding_result import Embedding
from meshmark.registry.commitment import Statement, key_check, opening_of
from meshmark.registry.database_tables import PENDING
from meshmark.registry.records import Copy, MarkedWith, Original
from meshmark.registry.registry import Registry
from meshmark.registry.times import now

__all__ = ["Entry", "mark_of", "recorded"]


@dataclass(eq=False, kw_only=True)
class Entry:
    """A copy that is being made. id: what it is to carry; `complete` is to be called before its file is moved."""

    registry: Registry
    key: Key
    original: Original
    id: int
    recipient: str | None
    path: Path
    marked_digest: str | None = field(default=None, init=False)

    def complete(self, result: Embedding, written: Path) -> Copy:
        """Enter how the copy was made; written: its file, whole, under its temporary name.

        Raises `RegistryError` where the registry cannot be written.
        """
        certificate = result.certificate
        digest, issued_at = digest_of_file(written), now()
        copy = Copy(
            id=self.id,
            key=self.key.fingerprint,
            original=self.original.digest,
            original_name=self.original.name,
            recipient=self.recipient,
            path=str(self.path),
            state=PENDING,
            mark=mark_of(certificate),
            mark_format=VERSION,
            meshmark=__version__,
            issued_at=issued_at,
            marked_digest=digest,
            commitment=opening_of(statement_of(self, digest, issued_at), self.key).commitment,
        )
        self.registry.complete(copy, json.dumps(certificate.to_dict(), allow_nan=False))
        self.marked_digest = digest
        return copy

    def is_in_place(self) -> bool:
        """Return whether the file has its name."""
        with suppress(OSError):
            return self.marked_digest is not None and digest_of_file(self.path) == self.marked_digest
        return False


@contextmanager
def recorded(
    registry: Registry,
    original: Original,
    key: Key,
    path: Path,
    *,
    id: int | None = None,
    bits: int = 64,
    recipient: str | None = None,
) -> Iterator[Entry]:
    """Hold an id for a copy while it is made, and say that it is issued when the block is left.

    The block completes the entry and then moves the file into its place. Where it fails the id is given up, unless
    the file is in place all the same: then the row stays, complete and pending.

    Raises `RegistryError` where the id is taken or the registry cannot be written.
    """
    place = Path(os.path.realpath(path))
    held = registry.reserve(original, key.fingerprint, id=id, bits=bits, recipient=recipient, path=str(place))
    entry = Entry(registry=registry, key=key, original=original, id=held, recipient=recipient, path=place)
    try:
        yield entry
    except BaseException:
        if not entry.is_in_place():
            with suppress(RegistryError):
                registry.withdraw(held, key.fingerprint)
        raise
    registry.confirm(held, key.fingerprint)


def statement_of(entry: Entry, marked_digest: str, issued_at: str) -> Statement:
    """Return what is committed to of a copy."""
    return Statement(
        id=format_id(entry.id),
        original_digest=entry.original.digest,
        marked_digest=marked_digest,
        recipient=entry.recipient,
        issued_at=issued_at,
        key=entry.key.fingerprint,
        key_check=key_check(entry.key),
    )


def mark_of(certificate: Certificate) -> MarkedWith:
    """Return how the mark of a certificate lies."""
    return MarkedWith(
        strength=certificate.strength,
        layers=str(certificate.more.get("layers", "both")),
        carriers=str(certificate.more.get("carriers", "cells")),
        lattice=certificate.lattice,
        spacing=certificate.spacing,
        step=certificate.step,
    )

"""A copy of a model for each of many recipients; interrupted at any moment, it goes on where it was.

What a crash leaves is told by the row and the file of a copy:

    no row                          not begun
    a pending row, no file          begun: made with the id that is held for it
    a pending row, its file         complete: confirmed
    an issued row, its file         done
    an issued row, no file          made again with its id, which gives the same file
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from meshmark.authentication.payload.content import Content
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import read_fields
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, format_id
from meshmark.errors import OutputError, RegistryError
from meshmark.io import Staging, input_files
from meshmark.io.file_digest import digest_of_file
from meshmark.marking.embedding_result import Embedding
from meshmark.marking.marked_file import embed_file
from meshmark.mesh import Mesh
from meshmark.registry.database_tables import ISSUED
from meshmark.registry.entering import original_of_mesh
from meshmark.registry.original_digest import digest_of_mesh
from meshmark.registry.recipients import Recipient
from meshmark.registry.recording import recorded
from meshmark.registry.records import Copy, Original
from meshmark.registry.registry import Registry
from meshmark.registry.rows import plain

__all__ = ["CERTIFICATE_SUFFIX", "Issue", "Issued", "check_rows", "issue"]

CERTIFICATE_SUFFIX = ".cert"
"""Extension of the certificate beside each copy."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Issue:
    """Copies of one model that are to be made.

    name: of its file; suffix: extension of the copies, with all its parts (".ply.gz"); folder: where they go, with
    their certificates. strength, layers, payload, tolerance, bits (64 or 32): as `embed` takes
    them. resume: go on with what is
    there.
    """

    mesh: Mesh
    name: str
    suffix: str
    folder: Path
    key: Key
    strength: str = "standard"
    layers: str | None = None
    payload: Content = None
    tolerance: str | None = None
    bits: int = ID_BITS
    resume: bool = False

    def path(self, recipient: Recipient) -> Path:
        """Return where the copy of a recipient goes."""
        return self.folder / f"{recipient.stem}{self.suffix}"


@dataclass(frozen=True, kw_only=True)
class Issued:
    """A copy that is in its place. made: now, not by an earlier run."""

    recipient: str
    id: int
    path: Path
    made: bool

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields, the id in hexadecimal."""
        return {"recipient": self.recipient, "id": format_id(self.id), "path": str(self.path)}


def issue(plan: Issue, recipients: Iterable[Recipient], registry: Registry) -> Iterator[Issued]:
    """Make a copy for each recipient, enter it, and yield it when it is in its place.

    The model is read, welded and measured once. Raises `RegistryError`, and as `check_rows` and `embed_file` do.
    """
    original = original_of_mesh(plan.mesh, plan.name, registry)
    known = _rows(plan, registry)
    for recipient in recipients:
        path = plan.path(recipient)
        row = known.get(_place(path))
        if row is not None:
            _check(plan, path, row, recipient)
            if _is_there(path, row):
                _finish(path, row, registry)
                yield Issued(recipient=recipient.name, id=row.id, path=path, made=False)
                continue
        yield _made(_Making(plan=plan, original=original, path=path, recipient=recipient.name), registry, row)


def check_rows(plan: Issue, recipients: Iterable[Recipient], registry: Registry) -> None:
    """Raise `OutputError` where a copy is there already and is not one that the plan may go on with."""
    known = _rows(plan, registry)
    for recipient in recipients:
        path = plan.path(recipient)
        if (row := known.get(_place(path))) is not None:
            _check(plan, path, row, recipient)
        elif os.path.lexists(path):
            raise OutputError(
                f"{path} exists already and is not in the registry, expected another folder", file=path
            )


def _rows(plan: Issue, registry: Registry) -> dict[str, Copy]:
    """Return the copies of the model and the key that are in the registry, by where they went."""
    rows = registry.copies(original=digest_of_mesh(plan.mesh), key=plan.key.fingerprint)
    return {copy.path: copy for copy in rows if copy.path is not None}


def _place(path: Path) -> str:
    return str(plain(os.path.realpath(path)))


def _check(plan: Issue, path: Path, row: Copy, recipient: Recipient) -> None:
    """Raise `OutputError` where a row that is there already is not one to go on with."""
    if not plan.resume:
        raise OutputError(
            f"{path} is in the registry already, as a copy for {row.recipient}; expected another folder, or "
            "--resume to go on",
            file=path,
        )
    if row.recipient != recipient.name:
        raise OutputError(
            f"{path} is a copy for {row.recipient}, not for {recipient.name}; expected the recipients that were "
            "begun with, and new ones after them",
            file=path,
        )


def _is_there(path: Path, row: Copy) -> bool:
    return row.marked_digest is not None and path.is_file() and digest_of_file(path) == row.marked_digest


def _finish(path: Path, row: Copy, registry: Registry) -> None:
    """Do what is left of a copy whose file is in its place."""
    beside = _certificate(path)
    if not beside.exists():
        text = registry.certificate(row.id, row.key)
        if text is not None:
            Certificate(**read_fields(text.encode("utf-8"))).save(beside)
    if row.state != ISSUED:
        registry.confirm(row.id, row.key)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Making:
    """One copy that is to be made."""

    plan: Issue
    original: Original
    path: Path
    recipient: str

    def embedded(self, id: int, staging: Staging) -> Embedding:
        """Put the copy with an id and its certificate into `staging`."""
        plan = self.plan
        result = embed_file(
            plan.mesh,
            self.path,
            plan.key,
            id=id,
            bits=plan.bits,
            strength=plan.strength,
            layers=plan.layers,
            payload=plan.payload,
            tolerance=plan.tolerance,
            staging=staging,
        )
        result.certificate.save(_certificate(self.path), staging)
        return result

    def issued(self, id: int) -> Issued:
        """Return what is to be said of it."""
        return Issued(recipient=self.recipient, id=id, path=self.path, made=True)


def _made(making: _Making, registry: Registry, row: Copy | None) -> Issued:
    """Make a copy, with the id of the row that is there already."""
    key, path = making.plan.key, making.path
    staging = Staging(replace=False, keep=input_files(making.plan.mesh))
    if row is not None and not path.exists():
        _certificate(path).unlink(missing_ok=True)  # of a move that a crash cut short: the model goes last
    if row is None or row.state != ISSUED:
        id = None if row is None else row.id
        with (
            recorded(
                registry, making.original, key, path, id=id, bits=making.plan.bits, recipient=making.recipient
            ) as entry,
            staging,
        ):
            result = making.embedded(entry.id, staging)
            entry.complete(result, staging.staged(path))
        return making.issued(entry.id)
    with staging:
        making.embedded(row.id, staging)
        if digest_of_file(staging.staged(path)) != row.marked_digest:
            raise RegistryError(
                f"{path} is gone, and what is made with its id {format_id(row.id)} is another file than was "
                "issued; expected the options and the version of meshmark of then",
                file=path,
            )
    return making.issued(row.id)


def _certificate(path: Path) -> Path:
    return path.with_name(f"{path.name}{CERTIFICATE_SUFFIX}")

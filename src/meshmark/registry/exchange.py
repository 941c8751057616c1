"""Registries as files: CSV for other programs, JSON lines with everything that is in them.

A row of CSV is a copy with the name and digest of its original; an import needs the columns `NEEDED`. JSON lines
also hold the certificates and the shapes of originals: {"original": ...}, then {"copy": ...} for each copy of it.
"""

from __future__ import annotations

import base64
import csv
import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any, Final

from meshmark.errors import InputError
from meshmark.registry.importing import NEEDED, Incoming, checked_copy, checked_original
from meshmark.registry.records import Copy, Original
from meshmark.registry.registry import Registry

__all__ = ["FORMATS", "exported", "incoming"]

FORMATS: Final = {".csv": "csv", ".jsonl": "jsonl"}
"""Extensions of the files, and their formats."""


def exported(registry: Registry, format: str) -> Iterator[str]:
    """Yield the text of a file with all copies of a registry, line by line.

    format: "csv" or "jsonl"; the latter has certificates and shapes, too.
    """
    if format == "csv":
        return _csv_lines(registry.copies())
    return _json_lines(registry)


def incoming(text: str, format: str) -> Iterator[Incoming]:
    """Yield the copies of a file; raises `InputError` that names the line that is wrong.

    format: "csv" or "jsonl".
    """
    return _from_csv(text) if format == "csv" else _from_json(text)


def _csv_lines(copies: list[Copy]) -> Iterator[str]:
    names = list(copies[0].to_dict()) if copies else list(NEEDED)
    for values in (dict(zip(names, names, strict=True)), *(each.to_dict() for each in copies)):
        line = io.StringIO()
        csv.writer(line, lineterminator="\n").writerow([values[name] for name in names])
        yield line.getvalue()


def _json_lines(registry: Registry) -> Iterator[str]:
    for original in registry.originals():
        shape = None if original.descriptor is None else base64.b64encode(original.descriptor).decode("ascii")
        yield json.dumps({"original": {**asdict(original), "descriptor": shape}}) + "\n"
        for copy in registry.copies(original=original.digest):
            text = registry.certificate(copy.id, copy.key)
            certificate = None if text is None else json.loads(text)
            yield json.dumps({"copy": {**copy.to_dict(), "certificate": certificate}}) + "\n"


def _from_csv(text: str) -> Iterator[Incoming]:
    rows = csv.DictReader(io.StringIO(text.removeprefix("\ufeff")))
    names = rows.fieldnames or []
    for name in NEEDED:
        if name not in names:
            raise InputError(f"the column '{name}' is missing, expected {', '.join(NEEDED)}")
    for number, values in enumerate(rows, start=2):
        with _line(number):
            copy = checked_copy(values)
            original = checked_original({"digest": copy.original, "name": copy.original_name})
        yield Incoming(copy=copy, original=original, certificate=None)


def _from_json(text: str) -> Iterator[Incoming]:
    known: dict[str, Original] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        with _line(number):
            values = _object(line)
            if "original" in values:
                original = checked_original(values["original"])
                known[original.digest] = original
                continue
            copy, certificate = checked_copy(values["copy"]), values["copy"].get("certificate")
            if copy.original not in known:
                raise InputError("its original is not in the lines before")
        yield Incoming(
            copy=copy,
            original=known[copy.original],
            certificate=None if certificate is None else json.dumps(certificate),
        )


@contextmanager
def _line(number: int) -> Iterator[None]:
    """Name the line in what is said of it."""
    try:
        yield
    except InputError as error:
        raise InputError(f"line {number}: {error}") from None


def _object(line: str) -> dict[str, Any]:
    try:
        values = json.loads(line)
    except ValueError:
        raise InputError("it is not JSON") from None
    if not isinstance(values, dict) or not any(
        isinstance(values.get(name), dict) for name in ("original", "copy")
    ):
        raise InputError("expected an object with 'original' or 'copy'")
    return values

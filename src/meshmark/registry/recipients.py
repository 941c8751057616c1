"""The recipients of copies, and the names of their files."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from meshmark.errors import InputError

__all__ = ["COLUMN", "Recipient", "read_recipients"]

COLUMN: Final = "recipient"
"""The column of a table that names them."""
_LONGEST = 80
_UNSAFE = re.compile(r"[^\w.@+-]+")
# Names of devices on Windows.
_RESERVED = {
    "con",
    "prn",
    "aux",
    "nul",
    *(f"{kind}{number}" for kind in ("com", "lpt") for number in range(10)),
}


@dataclass(frozen=True)
class Recipient:
    """Who gets a copy; stem: name of the file, without extension, unlike that of any other of the table."""

    name: str
    stem: str


def read_recipients(path: Path) -> list[Recipient]:
    """Return the recipients of a CSV file with a column `recipient`, in its order.

    Names of files hold letters, digits and .@+-_ only; a number tells apart what becomes the same.
    Raises `InputError` where the file cannot be read, has no such column, names none, or one twice.
    """
    try:
        text = path.read_text("utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or 'error'}", file=path) from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path} is no text, expected CSV in UTF-8 with a column '{COLUMN}'", file=path
        ) from None
    rows = csv.DictReader(io.StringIO(text, newline=""))
    if COLUMN not in (rows.fieldnames or ()):
        raise InputError(
            f"{path} has no column '{COLUMN}', expected a CSV file whose first line names the columns",
            file=path,
        )
    lines: dict[str, int] = {}
    stems: dict[str, str] = {}
    for row in rows:
        name, line = (row[COLUMN] or "").strip(), rows.line_num
        if not name:
            raise InputError(
                f"{path}, line {line}: the column '{COLUMN}' is empty, expected a name", file=path
            )
        if name in lines:
            raise InputError(f"{path}, line {line}: {name!r} is in line {lines[name]} already", file=path)
        lines[name] = line
        stems[_free(_stem(name), stems)] = name
    if not lines:
        raise InputError(f"{path} names no recipients, expected one a line", file=path)
    return [Recipient(name, stem) for stem, name in stems.items()]


def _stem(name: str) -> str:
    """Return what a name becomes as that of a file, on any system."""
    text = _UNSAFE.sub("_", unicodedata.normalize("NFC", name)).strip("._")[:_LONGEST].lower()
    return f"_{text}" if not text or text in _RESERVED else text


def _free(stem: str, taken: dict[str, str]) -> str:
    number, free = 1, stem
    while free in taken:
        number += 1
        free = f"{stem}-{number}"
    return free

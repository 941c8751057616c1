"""Rows that a measurement has made, one JSON object a line, so that an interrupted run can be continued."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

__all__ = ["Broken", "Copy", "Model", "append", "load"]

R = TypeVar("R", "Model", "Copy", "Broken")


@dataclass(frozen=True, kw_only=True)
class Model:
    """One public model that was marked, or why it was not. id: as hexadecimal digits, empty without a mark."""

    digest: str
    name: str
    id: str
    refused: str
    message: str


@dataclass(frozen=True, kw_only=True)
class Copy:
    """One compressed copy of a marked model. equal: to what the reference decoders give, to the last bit."""

    digest: str
    name: str
    form: str
    made: bool
    equal: bool
    found: bool
    before: int
    after: int


@dataclass(frozen=True, kw_only=True)
class Broken:
    """What reading one broken file did. own, child: peak memory in MB of the reader and of the decoder."""

    file: str
    kind: str
    number: int
    outcome: str
    own: int
    child: int
    seconds: float
    message: str


def load(path: Path, kind: type[R]) -> list[R]:
    """Return the rows of an earlier run, none where there is no file."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [kind(**json.loads(line)) for line in lines]


def append(path: Path, row: R) -> None:
    """Add a row to a file of rows."""
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(row)) + "\n")

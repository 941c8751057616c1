"""The results file of a batch: one JSON object a line, each on the disk before the next model is asked for.

A run that was cut off leaves at most its last line incomplete; the next run drops that line and goes on.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from meshmark.errors import InputError, OutputError
from meshmark.io.folder_lock import locked_folder

__all__ = ["RESULTS", "Results", "Row", "error_kind"]

Row = dict[str, Any]
"""What a single command says with --json, and `model`, `digest` and `exit_code`."""
RESULTS = "results.jsonl"
# Failures that say nothing of the model: another run tries it again.
_PASSING = {"killed", "timeout", "memory", "output", "registry", "interrupted"}


def error_kind(row: Row) -> str | None:
    """Return the kind of the error of a row, None for one with an answer."""
    error = row.get("error")
    return None if error is None else str(error["kind"])


class Results:
    """Rows of a folder; use as a context manager. Only the process that holds it writes to it.

    done: names of the models that have a row.
    """

    def __init__(self, folder: Path, *, resume: bool) -> None:
        """Open the results of a folder; resume: go on with those that are there, without failures that may pass.

        Raises `InputError` where there are some without `resume`, `OutputError` where the folder cannot be used.
        """
        self.path = folder / RESULTS
        self._lock = locked_folder(folder, "batch")
        try:
            if not resume and self.path.exists() and self.path.stat().st_size:
                raise InputError(
                    f"{self.path} is there from an earlier run, expected --resume to go on, or another folder",
                    file=self.path,
                )
            self.done = self._kept()
            self._file = self.path.open("ab")
            self._size = self.path.stat().st_size
        except BaseException as error:
            self._lock.close()
            if isinstance(error, OSError) and not isinstance(error, OutputError):
                raise OutputError(f"cannot write {self.path}: {error.strerror}", file=self.path) from None
            raise

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self._lock.close()

    def add(self, row: Row) -> None:
        """Add a row; it is on the disk when this returns. Raises `OutputError` where it does not fit there."""
        line = json.dumps(row, allow_nan=False).encode() + b"\n"
        try:
            self._file.write(line)
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            os.truncate(self.path, self._size)
            raise OutputError(f"cannot write {self.path}: {error.strerror}", file=self.path) from None
        self._size += len(line)
        self.done.add(row["model"])

    def counts(self) -> Counter[str]:
        """Return how many models have which outcome: an answer, or "failed: " and the kind of an error."""
        return Counter(_outcome(row) for row in _rows(self.path))

    def _kept(self) -> set[str]:
        """Leave only whole rows of models that are not to be tried again, and return the names of these."""
        if not self.path.exists():
            return set()
        done: set[str] = set()
        kept = self.path.with_name(f".{RESULTS}.kept")
        with kept.open("wb") as file:
            for row in _rows(self.path):
                if error_kind(row) not in _PASSING and row["model"] not in done:
                    done.add(row["model"])
                    file.write(json.dumps(row, allow_nan=False).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        kept.replace(self.path)
        return done


def _rows(path: Path) -> Iterator[Row]:
    """Yield the rows of a file; raises `InputError` for a line, other than an incomplete last one, that is none."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                return
            try:
                row = json.loads(line)
                row["model"]
            except (ValueError, KeyError, TypeError):
                raise InputError(f"{path}, line {number} is no result of a batch", file=path) from None
            yield row


def _outcome(row: Row) -> str:
    if (kind := error_kind(row)) is not None:
        return f"failed: {kind}"
    if "matches" in row:  # of `trace`, which also says what was read
        return "traced" if row["matches"] else "not traced"
    return str(row.get("presence") or row.get("verdict") or "marked")

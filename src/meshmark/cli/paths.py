"""Checks of the files a command is to write, made before any time is spent."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from meshmark.errors import CapacityError, InputError, OutputError

__all__ = ["check_output", "make_folder", "naming"]


@contextmanager
def naming(*paths: Path) -> Iterator[None]:
    """Name the files in errors about what they hold, unless one of them is named there."""
    try:
        yield
    except (InputError, CapacityError) as error:
        if any(path.name in str(error) for path in paths):
            raise
        kind = CapacityError if isinstance(error, CapacityError) else InputError
        raise kind(f"{', '.join(path.name for path in paths)}: {error}") from None


def check_output(path: Path, inputs: Iterable[Path], suffix: str | None = None) -> None:
    """Raise `OutputError` where `path` cannot be written, or is one of the inputs.

    suffix: the only extension, in lower case, that the file may have; None for any.
    """
    try:
        _check(path, inputs)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from None
    if suffix is not None and path.suffix.lower() != suffix:
        raise InputError(f"{path} has the extension '{path.suffix}', expected {suffix}")


def make_folder(path: Path) -> None:
    """Make a folder, and the folders above it; raises `OutputError` where that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {path}: {error.strerror}") from None


def _check(path: Path, inputs: Iterable[Path]) -> None:
    if path.is_dir():
        raise OutputError(f"{path} is a directory, expected the name of a file to write")
    if path.exists() and not path.is_file():
        raise OutputError(f"{path} is not an ordinary file, expected the name of a file to write")
    if not path.parent.is_dir():
        raise OutputError(f"cannot write {path}: the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write {path}: no permission to write in the folder {path.parent}")
    for other in inputs:
        if path.exists() and other.exists() and path.samefile(other):
            raise OutputError(f"{path} is also an input, which is never overwritten; expected another name")

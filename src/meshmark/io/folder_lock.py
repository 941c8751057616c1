"""A folder of results that one process at a time writes to."""

from __future__ import annotations

from pathlib import Path
from typing import IO

from meshmark.errors import OutputError

__all__ = ["locked_folder"]

_NAME = ".lock"


def locked_folder(folder: Path, noun: str) -> IO[str]:
    """Return an open file of a folder that only one process can hold; it lets go however that process ends.

    noun: what is running there, for the message. Raises `OutputError` where another process holds it, or the folder
    cannot be written to.
    """
    try:
        file = (folder / _NAME).open("w")
    except OSError as error:
        raise OutputError(f"cannot write in {folder}: {error.strerror}") from None
    try:
        import fcntl
    except ImportError:  # Windows: nothing keeps two runs apart there
        return file
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise OutputError(f"another {noun} is running in {folder}, expected a folder of its own") from None
    return file

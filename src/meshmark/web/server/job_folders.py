"""Temporary folders: one for each job, all in one folder that the server holds a lock on while it lives."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["job_folders", "remove_folder", "remove_stale"]

PREFIX = "meshmark-serve-"
_LOCK = "lock"


@contextmanager
def job_folders(home: Path | None = None) -> Iterator[Path]:
    """Give a folder, for its owner alone, and remove it in the end; those of servers that died are removed first.

    home: where it is made, the system's folder of temporary files if None.
    """
    above = Path(tempfile.gettempdir()) if home is None else home
    remove_stale(above)
    folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=above))
    with (folder / _LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            yield folder
        finally:
            remove_folder(folder)


def remove_stale(above: Path) -> None:
    """Remove the folders of this user's servers that do not live any more: nobody holds their locks."""
    for folder in above.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if folder.is_symlink() or folder.stat().st_uid != os.getuid():
                continue
            with (folder / _LOCK).open("r") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                remove_folder(folder)


def remove_folder(folder: Path) -> None:
    """Remove a folder and what is in it."""
    shutil.rmtree(folder, ignore_errors=True)

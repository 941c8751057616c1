"""Reading a file that a model names: within the model's own folder, not hidden, and through no link below it.

A model is a stranger's file: what it names must not be any file of the reader's, to be copied beside a result.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path, PurePosixPath

__all__ = ["head_inside", "is_inside", "is_link_error", "read_inside"]


def read_inside(folder: Path, name: str, most: int) -> bytes:
    """Return the bytes of an ordinary file below a folder.

    Parameters
    ----------
    folder : Path
        May itself be a link, or lie behind one.
    name : str
        Relative, of the file; none of its parts may be `..` or a link, or begin with a dot.
    most : int
        Bytes.

    Returns
    -------
    bytes

    Raises
    ------
    OSError
        The file cannot be read, is not an ordinary one, is longer than `most`, or is reached through a link.
    """
    handle = _opened(folder, name)
    with os.fdopen(handle, "rb") as file:
        if os.fstat(file.fileno()).st_size > most:
            raise OSError(errno.EFBIG, f"it is longer than {most:,} bytes")
        return file.read()


def head_inside(folder: Path, name: str, count: int) -> bytes:
    """Return the first bytes of a file that `read_inside` opens, empty where it does not."""
    try:
        with os.fdopen(_opened(folder, name), "rb") as file:
            return file.read(count)
    except (OSError, ValueError):
        return b""


def is_inside(folder: Path, name: str) -> bool:
    """Return whether `name` is an ordinary file below a folder that `read_inside` opens."""
    try:
        os.close(_opened(folder, name))
    except (OSError, ValueError):
        return False
    return True


def is_link_error(error: Exception) -> bool:
    """Return whether an error of `read_inside` is that a part of the path is a link, or no folder."""
    return isinstance(error, OSError) and error.errno in (errno.ELOOP, errno.ENOTDIR)


def _opened(folder: Path, name: str) -> int:
    """Return a descriptor of the file, each part of its path opened in the one before, links refused."""
    parts = PurePosixPath(name).parts
    if not parts or PurePosixPath(name).is_absolute() or any(part.startswith(".") for part in parts):
        raise OSError(errno.EACCES, "it is hidden, or not below the model's folder")
    if not hasattr(os, "O_NOFOLLOW") or os.open not in os.supports_dir_fd:
        return _without_descriptors(folder, parts)
    above = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    for part in parts[:-1]:
        try:
            below = os.open(part, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=above)
        finally:
            os.close(above)
        above = below
    try:
        handle = os.open(parts[-1], os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=above)
    finally:
        os.close(above)
    return _ordinary(handle)


def _without_descriptors(folder: Path, parts: tuple[str, ...]) -> int:
    place = folder
    for part in parts:
        place /= part
        if place.is_symlink():
            raise OSError(errno.ELOOP, "it is reached through a link")
    return _ordinary(os.open(place, os.O_RDONLY))


def _ordinary(handle: int) -> int:
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "it is not an ordinary file")
    return handle

"""Every error meshmark raises on purpose.

MeshmarkError            anything below; the command line prints its one sentence and exits with 2
├── InputError           a file, argument or value that cannot be used as given
│   ├── FormatError      a model file that breaks its format: says what, where, and what was expected
│   └── KeyFileError     a key file that cannot be read as a meshmark key
├── OutputError          a result that cannot be written (existing file, no space, no permission)
├── RegistryError        a registry that cannot be opened, read or written, or that refuses what is to go into it
└── CapacityError        a model that cannot carry the mark asked for; carries advice, and exits with 4
"""

from __future__ import annotations

import os
from typing import ClassVar

__all__ = [
    "CapacityError",
    "FormatError",
    "InputError",
    "KeyFileError",
    "MeshmarkError",
    "OutputError",
    "RegistryError",
    "without_frames",
]


class MeshmarkError(Exception):
    """Base of all expected failures; `str(error)` is one clear sentence.

    file: path of the file that it is about, None where there is none. kind: names the class in JSON.
    """

    kind: ClassVar[str] = "error"

    def __init__(self, sentence: str = "", *, file: str | os.PathLike[str] | None = None) -> None:
        super().__init__(sentence)
        self.file = None if file is None else os.fspath(file)


class InputError(MeshmarkError, ValueError):
    """A file, argument or value that cannot be used as given."""

    kind = "input"


class FormatError(InputError):
    """A model file that breaks its format."""

    kind = "format"


class KeyFileError(InputError):
    """A key file that cannot be read as a meshmark key."""

    kind = "key_file"


class OutputError(MeshmarkError, OSError):
    """A result that cannot be written."""

    kind = "output"


class RegistryError(MeshmarkError):
    """A registry that cannot be opened, read or written, or that refuses what is to go into it."""

    kind = "registry"


class CapacityError(MeshmarkError):
    """A model that cannot carry the mark asked for."""

    kind = "capacity"


def without_frames(error: CapacityError) -> CapacityError:
    """Return an error that does not keep the arrays of what failed."""
    error.__context__ = None
    return error.with_traceback(None)

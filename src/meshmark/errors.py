"""Every error meshmark raises on purpose.

MeshmarkError            anything below; the command line prints its one sentence and exits with 2
├── InputError           a file, argument or value that cannot be used as given
│   ├── FormatError      a model file that breaks its format: says what, where, and what was expected
│   └── KeyFileError     a key file that cannot be read as a meshmark key
├── OutputError          a result that cannot be written (existing directory, no space, no permission)
└── CapacityError        a model that cannot carry the mark asked for; carries advice
"""

from __future__ import annotations

__all__ = ["CapacityError", "FormatError", "InputError", "KeyFileError", "MeshmarkError", "OutputError"]


class MeshmarkError(Exception):
    """Base of all expected failures; `str(error)` is one clear sentence."""


class InputError(MeshmarkError, ValueError):
    """A file, argument or value that cannot be used as given."""


class FormatError(InputError):
    """A model file that breaks its format."""


class KeyFileError(InputError):
    """A key file that cannot be read as a meshmark key."""


class OutputError(MeshmarkError, OSError):
    """A result that cannot be written."""


class CapacityError(MeshmarkError):
    """A model that cannot carry the mark asked for."""

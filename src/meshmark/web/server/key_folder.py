"""The folder of key files: listed by label and public fingerprint; what a key is never leaves it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from meshmark.coding.keys import Key, is_key_file
from meshmark.errors import InputError, KeyFileError, OutputError

__all__ = ["LABEL", "KeyFolder", "ListedKey"]

LABEL = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
"""Labels of keys: names of files without their extension."""
_LABEL = re.compile(LABEL)
_SUFFIX = ".key"


@dataclass(frozen=True, kw_only=True)
class ListedKey:
    """What is told of a key. fingerprint: public; None where the file cannot be used, and problem says why."""

    label: str
    fingerprint: str | None
    problem: str | None = None


@dataclass(frozen=True)
class KeyFolder:
    """A folder of key files, each named after its label."""

    path: Path

    def make(self) -> None:
        """Make the folder, for its owner alone, where there is none; raises `OutputError` where that fails."""
        try:
            self.path.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            raise OutputError(
                f"cannot make the folder of keys {self.path}: {error.strerror}", file=self.path
            ) from None

    def listed(self) -> list[ListedKey]:
        """Return what is told of each key, by label."""
        try:
            found = sorted(path for path in self.path.iterdir() if self._is_listed(path))
        except OSError as error:
            raise InputError(f"cannot read the folder of keys: {error.strerror or 'error'}") from None
        return [_listed(path) for path in found]

    def create(self, label: str) -> ListedKey:
        """Make a new key; raises `InputError` for a label that is none, `OutputError` where it is taken."""
        path = self._place(label)
        if path.exists():
            raise OutputError(f"there is a key '{label}' already, and a key is never overwritten")
        key = Key.generate()
        try:
            key.save(path)
        except OutputError:
            raise OutputError(f"the key '{label}' cannot be written") from None
        return ListedKey(label=label, fingerprint=key.fingerprint)

    def file_of(self, label: str) -> Path:
        """Return the file of a key; raises `InputError` where there is none of this label."""
        path = self._place(label)
        if not self._is_listed(path):
            raise InputError(f"there is no key '{label}' in the folder of keys")
        return path

    def _place(self, label: str) -> Path:
        if _LABEL.match(label) is None:
            raise InputError(
                "a label is of 1 to 64 letters, digits, dots, dashes and underscores, the first a letter or digit"
            )
        return self.path / f"{label}{_SUFFIX}"

    def _is_listed(self, path: Path) -> bool:
        named = path.suffix == _SUFFIX and _LABEL.match(path.stem) is not None
        return named and path.is_file() and is_key_file(path)


def _listed(path: Path) -> ListedKey:
    try:
        return ListedKey(label=path.stem, fingerprint=Key.load(path).fingerprint)
    except KeyFileError as error:
        problem = str(error).replace(f"{path.parent}/", "").partition(": `chmod")[0]
        return ListedKey(label=path.stem, fingerprint=None, problem=problem)

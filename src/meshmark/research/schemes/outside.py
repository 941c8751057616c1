"""Schemes from outside: of other installed packages, by entry point, and of a single file that ends in .py."""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import sys
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from inspect import isclass
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from meshmark.errors import InputError
from meshmark.research.schemes.scheme import Scheme, SharedMark

__all__ = ["ENTRY_POINTS", "FILE_ENDING", "file_digest", "load_file", "load_point", "points"]

# The group of entry points under which a package offers schemes.
ENTRY_POINTS = "meshmark.schemes"
# A name that ends so is the path of a file with one scheme in it.
FILE_ENDING = ".py"

_PARTS = ("title", "source", "bits", "blind", "embed", "extract")


def points() -> dict[str, EntryPoint]:
    """Return the entry points of installed packages, by name."""
    return {point.name: point for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda p: p.name)}


def load_point(name: str, point: EntryPoint) -> Scheme:
    """Return the scheme of an entry point; raises `InputError` where it is none."""
    return _checked(point.load()(), f"scheme '{name}' ({point.value})")


def load_file(path: str) -> Scheme:
    """Return the scheme of a file: of the one class in it that has `embed` and `extract`.

    Raises `InputError` where there is no such file, running it fails, or it has no such class or several.
    """
    module = _module(path, file_digest(path))
    own = [value for value in vars(module).values() if isclass(value) and value.__module__ == module.__name__]
    found = [value for value in own if hasattr(value, "embed") and hasattr(value, "extract")]
    if len(found) != 1:
        names = ", ".join(value.__name__ for value in found) or "none"
        raise InputError(f"{path} has {names}, expected one class with the methods embed and extract")
    return _checked(found[0](), f"the scheme {found[0].__name__} in {path}")


def file_digest(path: str) -> str:
    """Return eight hexadecimal digits that tell one content of a file from another."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the scheme {path}: {error.strerror}") from None
    return hashlib.blake2b(content, digest_size=4).hexdigest()


class _Fresh(importlib.machinery.SourceFileLoader):
    """Compiles the file as it is now: what was compiled before is known by its time and size, and may be older."""

    def get_code(self, fullname: str) -> CodeType:
        """Return the compiled source of the module."""
        del fullname  # the path is known
        return self.source_to_code(self.get_data(self.path), self.path)


@lru_cache(maxsize=16)
def _module(path: str, digest: str) -> ModuleType:
    """Return the module of a file, run once for each content of it."""
    name = f"meshmark_scheme_{Path(path).stem}_{digest}"
    source = Path(path).resolve()
    spec = importlib.util.spec_from_file_location(name, source, loader=_Fresh(name, str(source)))
    if spec is None or spec.loader is None:
        raise InputError(f"{path} cannot be loaded, expected a file of Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickles look for it there
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"the scheme {path} cannot be loaded: {reason}") from None
    return module


def _checked(scheme: Any, what: str) -> Scheme:
    if not isinstance(scheme, Scheme):
        missing = [part for part in _PARTS if not hasattr(scheme, part)]
        raise InputError(f"{what} lacks {', '.join(missing)}")
    if isinstance(getattr(scheme, "shared_mark", None), SharedMark):
        if scheme.blind:
            raise InputError(f"{what} has shared_mark and is blind, expected one that reads with a reference")
        if not hasattr(scheme, "extract_by_reference"):
            raise InputError(f"{what} has shared_mark and lacks extract_by_reference")
    return scheme

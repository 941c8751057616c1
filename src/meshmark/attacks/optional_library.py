"""Libraries that an attack needs and a plain installation lacks."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from meshmark.errors import InputError

__all__ = ["library", "missing"]


def library(module: str, extra: str) -> Any:
    """Import and return `module`; raises `InputError` naming the extra that installs it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise missing(module, extra) from error


def missing(module: str, extra: str) -> InputError:
    """Return the error that says which extra installs a module."""
    return InputError(
        f"this attack needs {module.partition('.')[0]}, expected it from: pip install meshmark[{extra}]"
    )

"""Names that are imported when they are first used, so that a program loads only what it needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

__all__ = ["late_function", "late_names"]


def late_names(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Return a package's `__getattr__`, which imports the names that the package offers from its modules.

    Parameters
    ----------
    package : str
        Its dotted name.
    homes : mapping of str to str
        For each name, the module that defines it, without "meshmark." before it.

    Returns
    -------
    callable
        From a name to what it stands for; raises `AttributeError` for one that `homes` does not have.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"meshmark.{homes[name]}"), name)
        setattr(import_module(package), name, value)
        return value

    return find


def late_function(module: str, name: str) -> Callable[..., Any]:
    """Return a function that calls the function `name` of a module, which is imported with the first call."""

    def call(*args: Any, **kwargs: Any) -> Any:
        return getattr(import_module(module), name)(*args, **kwargs)

    return call

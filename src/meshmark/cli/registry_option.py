"""The option --registry, and the registry that it names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.errors import InputError, RegistryError

if TYPE_CHECKING:
    from meshmark.registry.registry import Registry

__all__ = ["REGISTRY_VARIABLE", "RegistryIn", "named_registry", "open_registry", "registry_class"]

REGISTRY_VARIABLE = "MESHMARK_REGISTRY"
"""Environment variable that stands in for the option."""
PARTS = ("meshmark.registry", "sqlalchemy", "alembic")
"""What the extra `registry` brings: the wheel meshmark-registry, and its libraries."""
_HELP = "Registry of copies: the path of an SQLite file, or postgresql://USER:PASSWORD@HOST/NAME."
_OPTION = typer.Option("--registry", metavar="URL", envvar=REGISTRY_VARIABLE, help=_HELP)
RegistryIn = Annotated[str | None, _OPTION]


def named_registry(url: str | None) -> str:
    """Return the place of the registry of a command that needs one; raises `InputError` where it is not named."""
    if not url:
        raise InputError(f"no registry is named, expected --registry URL or the variable {REGISTRY_VARIABLE}")
    return url


def open_registry(url: str | None) -> Registry:
    """Return the registry of a command that needs one.

    Raises `InputError` where it is not named, and `RegistryError` where it cannot be opened.
    """
    return registry_class().open(named_registry(url))


def registry_class() -> type[Registry]:
    """Return the class `Registry`; raises `RegistryError` where the extra is not installed."""
    try:
        from meshmark.registry.registry import Registry
    except ModuleNotFoundError as error:
        if not str(error.name).startswith(PARTS):
            raise
        raise RegistryError(
            "the registry is not part of this installation, get it with: pip install meshmark[registry]"
        ) from None
    return Registry

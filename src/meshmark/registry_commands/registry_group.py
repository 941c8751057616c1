"""`meshmark registry`: who got which copy. A group of commands, each in a module here."""

from __future__ import annotations

from collections.abc import Callable

from meshmark.cli.command_group import command_group
from meshmark.registry_commands.registry_exchange import export_registry, import_registry
from meshmark.registry_commands.registry_issue import issue_copies
from meshmark.registry_commands.registry_prove import prove_copy, verify_proof
from meshmark.registry_commands.registry_rows import init_registry, list_registry, show_copy

__all__ = ["REGISTRY_COMMANDS", "registry"]

REGISTRY_COMMANDS: dict[str, Callable[..., int]] = {
    "init": init_registry,
    "list": list_registry,
    "show": show_copy,
    "issue": issue_copies,
    "prove": prove_copy,
    "verify": verify_proof,
    "import": import_registry,
    "export": export_registry,
}
"""In the order in which `meshmark registry --help` lists them."""

registry = command_group(
    "registry",
    "Keep who got which copy.\n\n"
    "A registry is a database of originals and of the marked copies that were made of them: an SQLite file, or "
    "PostgreSQL. It never holds a key.",
    REGISTRY_COMMANDS,
)

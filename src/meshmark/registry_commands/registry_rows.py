"""`meshmark registry init`, `list` and `show`: a registry made, and looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson
from meshmark.cli.output import answer, described, plural
from meshmark.cli.registry_option import RegistryIn, named_registry, open_registry, registry_class

if TYPE_CHECKING:
    from meshmark.registry.records import Copy

__all__ = ["init_registry", "list_registry", "show_copy"]

_NOBODY = "-"


def init_registry(*, registry: RegistryIn = None, as_json: AsJson = False) -> int:
    """Make a registry, or bring one of an earlier version up to date.

    What is in it stays. Of an SQLite file the folder must exist; of PostgreSQL the database must.
    """
    opened, changed = registry_class().create(named_registry(registry))
    with opened:
        place = opened.database.shown
    words = f"Registry ready: {place}." if changed else f"The registry {place} was there and up to date."
    answer(words, described({"registry": place, "changed": changed}), as_json)
    return 0


def list_registry(
    *,
    registry: RegistryIn = None,
    recipient: Annotated[
        str | None, typer.Option("--to", metavar="NAME", help="Copies of this recipient alone.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """List the copies of a registry, one a line."""
    with open_registry(registry) as opened:
        found = opened.copies(recipient=recipient)
    lines = [f"{plural(len(found), 'copy/copies')}", *map(_line, found)]
    answer("\n".join(lines), described({"records": [each.to_dict() for each in found]}), as_json)
    return 0


def show_copy(
    *,
    identity: Annotated[str, typer.Argument(metavar="ID", help="16 hexadecimal digits, or 8.")],
    registry: RegistryIn = None,
    as_json: AsJson = False,
) -> int:
    """Show what a registry holds of one id.

    Exit code 1: the id is not there.
    """
    from meshmark.coding.message import parse_id

    number = parse_id(identity)
    with open_registry(registry) as opened:
        found = opened.copies_with_id(number)
    if not found:
        answer(
            f"The registry has no copy with the id {identity.lower()}.", described({"records": []}), as_json
        )
        return 1
    lines = [
        f"{name.replace('_', ' '):16} {_NOBODY if value is None else value}"
        for each in found
        for name, value in each.to_dict().items()
    ]
    answer("\n".join(lines), described({"records": [each.to_dict() for each in found]}), as_json)
    return 0


def _line(copy: Copy) -> str:
    from meshmark.coding.message import format_id

    when = copy.issued_at or copy.state
    pending = " (pending)" if copy.issued_at and copy.state != "issued" else ""
    known = (copy.recipient, copy.original_name, copy.path)
    return "  ".join([format_id(copy.id), f"{when:20}{pending}", *(each or _NOBODY for each in known)])

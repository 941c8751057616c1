"""`meshmark registry import` and `export`: registries as CSV or JSON lines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.options import AsJson, Force
from meshmark.cli.output import answer, described, plural
from meshmark.cli.paths import naming, staged
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.errors import InputError

__all__ = ["export_registry", "import_registry"]


def export_registry(
    *,
    out: Annotated[
        Path, typer.Argument(metavar="OUT", help="File to write: .csv, or .jsonl for JSON lines.")
    ],
    registry: RegistryIn = None,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Write the copies of a registry to a file.

    JSON lines hold everything, and `import` makes the same registry of them. CSV is for other programs: it is
    without certificates and shapes, so that of what is imported from it suspects are told by their ids alone.
    """
    format = _format_of(out)
    staging = staged([(out, None)], [], force)
    from meshmark.registry.exchange import exported

    with open_registry(registry) as opened, staging:
        lines = list(exported(opened, format))
        staging.put(out, "".join(lines).encode("utf-8"))
    written = f"Exported: {out}."
    answer(written, described({"lines": len(lines)}, outputs={"file": out}), as_json)
    return 0


def import_registry(
    *,
    source: Annotated[
        Path, typer.Argument(metavar="IN", help="File to read: .csv, or .jsonl for JSON lines.")
    ],
    registry: RegistryIn = None,
    as_json: AsJson = False,
) -> int:
    """Enter the copies of a file into a registry, all of them or none.

    The file is one that `export` wrote, or a table with the columns `id`, `key` (the public fingerprint) and
    `original_digest` at least. Copies that are there already are left alone; an id of another copy is refused.
    """
    format = _format_of(source)
    try:
        text = source.read_text("utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {source}: {error.strerror or 'error'}", file=source) from None
    except UnicodeDecodeError:
        raise InputError(f"{source} is no text, expected CSV or JSON lines in UTF-8", file=source) from None
    from meshmark.registry.exchange import incoming

    with naming(source), open_registry(registry) as opened:
        new, there = opened.add(incoming(text, format))
    words = f"Imported: {plural(new, 'copy/copies')} from {source}; {there} were there already."
    answer(words, described({"imported": new, "present": there}, source), as_json)
    return 0


def _format_of(path: Path) -> str:
    from meshmark.registry.exchange import FORMATS

    if path.suffix.lower() not in FORMATS:
        expected = " or ".join(FORMATS)
        raise InputError(f"{path} has the extension '{path.suffix}', expected {expected}", file=path)
    return FORMATS[path.suffix.lower()]

"""`meshmark trace`: whose copy is it?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from meshmark.cli.model_input import read_model
from meshmark.cli.options import AsJson, ForceKeyed, KeyFile, Search
from meshmark.cli.output import answer, described
from meshmark.cli.paths import naming, staged
from meshmark.cli.progress import progress
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.cli.report_origin import report_origin
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.registry.tracing import Match, Trace

__all__ = ["trace"]

_HOW = {
    "blind": "read with the key alone",
    "authentication": "read from its authentication marks",
    "registered": "read by the certificate of its original",
}


def trace(
    *,
    suspects: Annotated[list[Path], typer.Argument(metavar="SUSPECT...", help="Models that were found.")],
    key: KeyFile,
    registry: RegistryIn = None,
    search: Annotated[
        Search, typer.Option(help="quick is fast; wide spends more time on hard cases.")
    ] = Search.quick,
    time_limit: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Stop with a suspect after this many seconds.")
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(metavar="OUT.html", help="Also write a page of the suspect, which must be one alone."),
    ] = None,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Say whose copy a model is, by the registry of copies.

    Neither the original nor the certificate need be told: originals of which the suspect may be a part are looked
    up by their shape. Of an average of copies all are named that can be. A recipient is named only where the chance
    to accuse any innocent one of the registry is below one in a million.

    Exit code 0: every suspect names a recipient; 1: one names none.
    """
    from meshmark.coding.keys import Key

    if report is not None and len(suspects) != 1:
        raise InputError(f"--report is of one suspect, but {len(suspects)} are named, expected one")
    staging = staged([(report, ".html")], [*suspects, key], force)
    secret = Key.load(key, force=force)
    lines, traces = [], []
    with open_registry(registry) as opened:
        for path in suspects:
            mesh = read_model(path, None, staging)
            from meshmark.registry.tracing import trace as find

            with progress(f"tracing {path.name}"), naming(path):
                found = find(mesh, secret, opened, search=search.value, time_limit=time_limit)
            if report is not None:
                from meshmark.report.trace_page import write_trace_page

                with progress("drawing"), staging:
                    write_trace_page(mesh, found, report_origin(mesh, path, secret), report, staging)
            lines.append(_words(found, path))
            traces.append({"suspect": str(path), **found.to_dict()})
    fields: dict[str, Any] = {"traces": traces}
    if len(traces) == 1:
        fields |= traces[0]
    answer("\n".join(lines), described(fields, suspects, {"report": report}, secret), as_json)
    return 0 if all(each["matches"] for each in traces) else 1


def _words(found: Trace, path: Path) -> str:
    if not found.matches:
        return f"{path} names no recipient. {found.extraction.advice}"
    return "\n".join(f"{path} {_match(each)}" for each in found.matches)


def _match(match: Match) -> str:
    from meshmark.coding.chance import in_words
    from meshmark.coding.message import format_id

    whom = f"is the copy of {match.recipient}" if match.recipient else "is a copy without a recipient"
    chance = in_words(match.log10_false_accusation)
    return (
        f"{whom}: id {format_id(match.id)}, made of {match.original}, {_HOW[match.method]}; chance of accusing "
        f"an innocent recipient {chance}"
    )

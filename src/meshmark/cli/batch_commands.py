"""`meshmark batch embed`, `extract`, `authenticate` and `trace`: the single commands, for many models."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from meshmark.cli.options import (
    Bits,
    ForceKey,
    ForceKeyed,
    KeyFile,
    LikeEmbedLayers,
    LikeEmbedPayload,
    LikeEmbedStrength,
    LikeEmbedTolerance,
    Search,
    Strength,
)
from meshmark.cli.registry_option import RegistryIn, named_registry

if TYPE_CHECKING:
    from meshmark.cli.batch_job import BatchCommand

__all__ = ["batch_authenticate", "batch_embed", "batch_extract", "batch_trace"]

_Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help='Models: a folder, with those below; a pattern in quotes, such as "models/**/*.ply"; a text file with '
        "a path on each line; or a CSV table with a column path, and perhaps id and recipient.",
    ),
]
_Out = Annotated[
    Path, typer.Argument(metavar="OUT", help="Folder for the results; made where it is not there.")
]
_Workers = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes; without it, one for each core.")
]
_Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Scheduler of a Dask cluster, whose workers see the same files.",
    ),
]
_Resume = Annotated[
    bool,
    typer.Option("--resume", help="Go on with what an interrupted run left, and try passing failures again."),
]
_Seconds = Annotated[
    float, typer.Option("--kill-after", min=1.0, metavar="SECONDS", help="Give up a model after this time.")
]
_Memory = Annotated[
    int, typer.Option("--memory", min=100, metavar="MB", help="Memory that a process may use, in MiB.")
]
_JsonLines = Annotated[
    bool, typer.Option("--json-lines", help="Also print each row of the results as it comes.")
]
_SEARCH = typer.Option(help="As `extract` takes it.")
_STOP = typer.Option(metavar="SECONDS", help="As `extract` takes it.")
_HOUR, _GIGABYTES = 3600.0, 4096


def batch_embed(
    *,
    source: _Source,
    out: _Out,
    key: KeyFile,
    registry: RegistryIn = None,
    certificates: Annotated[
        bool, typer.Option("--certificates", help="Also write a certificate beside each marked file, .cert.")
    ] = False,
    bits: Annotated[Bits, typer.Option(help="As `embed` takes it.")] = Bits.long,
    strength: LikeEmbedStrength = Strength.standard,
    layers: LikeEmbedLayers = None,
    payload: LikeEmbedPayload = None,
    tolerance: LikeEmbedTolerance = None,
    workers: _Workers = None,
    scheduler: _Scheduler = None,
    resume: _Resume = False,
    seconds: _Seconds = _HOUR,
    memory: _Memory = _GIGABYTES,
    json_lines: _JsonLines = False,
    force: ForceKeyed = False,
) -> int:
    """Mark many models.

    Each marked copy goes to the place in OUT that its model has below SOURCE. Its id comes from key, file and
    place, unless a table gives one: two runs make the same copies. OUT/results.jsonl has a line for each model,
    with what `embed --json` says of it, or the reason why it has no mark.

    Exit code 1: a model has no mark.
    """
    options = {"--strength": strength, "--layers": layers, "--payload": payload, "--tolerance": tolerance}
    if bits != Bits.long:
        options["--bits"] = bits
    return _run(
        _command("embed", key, out, options, registry=registry, certificates=certificates),
        source=source,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        seconds=seconds,
        memory_mb=memory,
        json_lines=json_lines,
        force=force,
    )


def batch_extract(
    *,
    source: _Source,
    out: _Out,
    key: KeyFile,
    registry: RegistryIn = None,
    search: Annotated[Search, _SEARCH] = Search.quick,
    time_limit: Annotated[float | None, _STOP] = None,
    workers: _Workers = None,
    scheduler: _Scheduler = None,
    resume: _Resume = False,
    seconds: _Seconds = _HOUR,
    memory: _Memory = _GIGABYTES,
    json_lines: _JsonLines = False,
    force: ForceKey = False,
) -> int:
    """Look for a mark in many models.

    OUT/results.jsonl has a line for each model, with what `extract --json` says of it, or why it cannot be read.

    Exit code 1: a model has an error instead of an answer.
    """
    options = {"--search": search, "--time-limit": time_limit}
    return _run(
        _command("extract", key, out, options, registry=registry),
        source=source,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        seconds=seconds,
        memory_mb=memory,
        json_lines=json_lines,
        force=force,
    )


def batch_authenticate(
    *,
    source: _Source,
    out: _Out,
    key: KeyFile,
    workers: _Workers = None,
    scheduler: _Scheduler = None,
    resume: _Resume = False,
    seconds: _Seconds = _HOUR,
    memory: _Memory = _GIGABYTES,
    json_lines: _JsonLines = False,
    force: ForceKey = False,
) -> int:
    """Say of many models whether they were changed since marking.

    OUT/results.jsonl has a line for each model, with what `authenticate --json` says of it, or why it cannot be
    read.

    Exit code 1: a model has an error instead of an answer.
    """
    return _run(
        _command("authenticate", key, out, {}),
        source=source,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        seconds=seconds,
        memory_mb=memory,
        json_lines=json_lines,
        force=force,
    )


def batch_trace(
    *,
    source: _Source,
    out: _Out,
    key: KeyFile,
    registry: RegistryIn = None,
    search: Annotated[Search, _SEARCH] = Search.quick,
    time_limit: Annotated[float | None, _STOP] = None,
    workers: _Workers = None,
    scheduler: _Scheduler = None,
    resume: _Resume = False,
    seconds: _Seconds = _HOUR,
    memory: _Memory = _GIGABYTES,
    json_lines: _JsonLines = False,
    force: ForceKey = False,
) -> int:
    """Say of many models whose copies they are, by the registry of copies.

    OUT/results.jsonl has a line for each model, with what `trace --json` says of it, or why it cannot be read.

    Exit code 1: a model has an error instead of an answer.
    """
    options = {"--search": search, "--time-limit": time_limit}
    return _run(
        _command("trace", key, out, options, registry=named_registry(registry)),
        source=source,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        seconds=seconds,
        memory_mb=memory,
        json_lines=json_lines,
        force=force,
    )


def _command(
    name: str,
    key: Path,
    out: Path,
    options: Mapping[str, object],
    *,
    registry: str | None = None,
    certificates: bool = False,
) -> BatchCommand:
    """Return what is done with each model; options: of the single command, None for one that is not given."""
    from meshmark.cli.batch_job import BatchCommand

    given = {name: value for name, value in options.items() if value is not None}
    return BatchCommand(
        name=name,
        key=str(key),
        out=str(out),
        options=tuple(word for name, value in given.items() for word in (name, str(value))),
        certificates=certificates,
        registry=registry,
    )


def _run(command: BatchCommand, **options: Any) -> int:
    """Run a batch; options: fields of `BatchOptions`."""
    from meshmark.cli.batch_run import BatchOptions, run_batch

    return run_batch(command, BatchOptions(**options))

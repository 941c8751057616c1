"""`meshmark registry issue`: a copy of a model for each recipient of a table."""

from __future__ import annotations

import shutil
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.model_input import read_model
from meshmark.cli.options import (
    AsJson,
    Bits,
    ForceKey,
    KeyFile,
    LikeEmbedLayers,
    LikeEmbedPayload,
    LikeEmbedStrength,
    LikeEmbedTolerance,
    ModelIn,
    Strength,
)
from meshmark.cli.output import answer, described, plural
from meshmark.cli.paths import STANDARD_INPUT, make_folder, naming
from meshmark.cli.progress import counted
from meshmark.cli.registry_option import REGISTRY_VARIABLE, RegistryIn, named_registry, open_registry
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.registry.issuing import Issued

__all__ = ["issue_copies"]


def issue_copies(
    *,
    model: ModelIn,
    recipients: Annotated[
        Path, typer.Option("--to", metavar="CSV", help="Table of recipients, with a column `recipient`.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the copies; made where it is not there.")
    ],
    key: KeyFile,
    registry: RegistryIn = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes that make copies.")] = 1,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on with what an interrupted run left, and with new recipients."),
    ] = False,
    bits: Annotated[
        Bits, typer.Option(help="As `embed` takes it; 0 tells no copy from another.")
    ] = Bits.long,
    strength: LikeEmbedStrength = Strength.standard,
    layers: LikeEmbedLayers = None,
    payload: LikeEmbedPayload = None,
    tolerance: LikeEmbedTolerance = None,
    part: Annotated[str | None, typer.Option(hidden=True)] = None,
    force: ForceKey = False,
    as_json: AsJson = False,
) -> int:
    """Make an individual copy of a model for each recipient.

    Each copy has an id of its own, a row in the registry, and its certificate beside it. Files are named after the
    recipients. What was interrupted, at whatever moment, goes on with --resume: no copy is made twice, no file is
    half written, and ids that were held are kept.
    """
    from meshmark.coding.keys import Key
    from meshmark.registry.recipients import read_recipients

    start = perf_counter()
    place = named_registry(registry)
    if model == STANDARD_INPUT:
        raise InputError("copies are made of a model file, expected its name instead of standard input")
    if bits == Bits.none:
        raise InputError("a registry tells copies by their ids, expected --bits 64 or 32")
    wanted = read_recipients(recipients)
    secret = Key.load(key, force=force)
    if part is None:
        _prepare(out, resume)
    mesh = read_model(model, None)
    from meshmark.registry.issuing import Issue, check_rows, issue

    plan = Issue(
        mesh=mesh,
        name=model.name,
        suffix=_suffix(model),
        folder=out,
        key=secret,
        strength=strength.value,
        layers=None if layers is None else layers.value,
        payload=payload if payload in (None, "miniature", "none") else Path(str(payload)),
        tolerance=None if tolerance is None else tolerance.value,
        bits=int(bits),
        resume=resume,
    )
    if part is not None:
        from meshmark.registry.issue_workers import part_of, run_part

        with naming(model), open_registry(place) as opened:
            return run_part(issue(plan, part_of(wanted, part), opened))
    line = ["registry", "issue", str(model), "--to", str(recipients), "--out", str(out), "--key", str(key)]
    options = {"--strength": strength, "--layers": layers, "--payload": payload, "--tolerance": tolerance}
    options["--bits"] = bits
    line += [word for name, value in options.items() if value is not None for word in (name, str(value))]
    line += [name for name, given in (("--resume", resume), ("--force", force)) if given]
    from meshmark.registry.issue_workers import worked

    found: list[Issued] = []
    with naming(model), open_registry(place) as opened, counted("copies") as report:
        check_rows(plan, wanted, opened)
        apart = {REGISTRY_VARIABLE: place}
        for each in issue(plan, wanted, opened) if workers == 1 else worked(line, workers, apart):
            found.append(each)
            report(len(found), len(wanted), 0)
    order = {each.name: number for number, each in enumerate(wanted)}
    found.sort(key=lambda each: order[each.recipient])
    new = sum(each.made for each in found)
    words = f"Issued: {plural(new, 'copy/copies')} of {model} in {out}"
    words += f"; {len(found) - new} were there already." if new < len(found) else "."
    fields = {"issued": [each.to_dict() for each in found], "seconds": perf_counter() - start}
    answer(words, described(fields, model, {"folder": out}, secret), as_json)
    return 0


def _prepare(out: Path, resume: bool) -> None:
    """Make the folder, and remove what a run that was killed left under temporary names."""
    from meshmark.io.staging import TEMPORARY

    make_folder(out)
    for left in out.glob(TEMPORARY) if resume else ():
        shutil.rmtree(left, ignore_errors=True)


def _suffix(model: Path) -> str:
    """Return the extension of a model's name, with that of a compressed one: ".ply.gz"."""
    last = model.suffix
    return f"{Path(model.stem).suffix}{last}" if last.lower() == ".gz" else last

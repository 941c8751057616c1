"""`meshmark attack`: simulate common edits and attacks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import AsJson, Force, ModelFormat, ModelFormatIn
from meshmark.cli.output import answer, described, plural, say
from meshmark.cli.paths import naming, staged, written_beside
from meshmark.cli.progress import progress
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.attacks import Attacked, Chain
    from meshmark.io import Staging
    from meshmark.mesh import Mesh

__all__ = ["attack"]

_JOINTS = (":", "+")
_INDENT = 16


def attack(
    *,
    model: Annotated[
        Path | None,
        typer.Argument(metavar="IN", help="Model to attack; it stays as it is. - for standard input."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Argument(
            metavar="OUT", help="File to write; in the format of IN unless its name says otherwise."
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="An attack, or a chain such as crop:0.1+noise:0.003+similarity."),
    ] = None,
    strength: Annotated[
        float | None,
        typer.Argument(
            metavar="STRENGTH", help="How strong; 0 changes nothing. Without it, the attack's default."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Start of the random numbers.")] = 0,
    others: Annotated[
        list[Path] | None,
        typer.Option(
            "--with",
            metavar="MODEL",
            help="Another marked model, for collusion (once for each copy), copy, paste.",
        ),
    ] = None,
    map_out: Annotated[
        Path | None,
        typer.Option(
            "--map",
            metavar="OUT.csv",
            help="Also write each vertex's number before, and whether a local edit made it.",
        ),
    ] = None,
    format: ModelFormatIn = None,
    force: Force = False,
    as_list: Annotated[bool, typer.Option("--list", help="List the attacks and exit.")] = False,
    as_json: AsJson = False,
) -> int:
    """Simulate common edits and attacks.

    IN after the attack goes to OUT. The same seed gives the same result.
    `meshmark attack --list` names all attacks, with their strengths and what they imitate.
    """
    if as_list:
        _list(as_json)
        return 0
    if model is None or out is None or name is None:
        raise InputError("an argument is missing, expected IN OUT NAME [STRENGTH], or --list")
    chain = _chain(name, strength)
    used = others or []
    _check_needs(chain, used)
    staging = staged([(out, None), (map_out, ".csv")], [model, *used], force)
    job = _Job(model=model, format=format, out=out, map_out=map_out, others=used, staging=staging)
    fields = _attacked(job, chain, seed)
    words = (
        f"Attacked: {named(model)} -> {out}; {chain}, seed {seed}; "
        f"{plural(fields['vertices'], 'vertex/vertices')} (before: {fields['vertices_before']:,}), "
        f"{plural(fields['faces'], 'face')} (before: {fields['faces_before']:,})"
    )
    answer(words, described(fields, model, {"model": out, "map": map_out}), as_json)
    return 0


@dataclass(frozen=True, kw_only=True)
class _Job:
    """The files of one attack."""

    model: Path
    format: ModelFormat | None
    out: Path
    map_out: Path | None
    others: list[Path]
    staging: Staging


def _chain(name: str, strength: float | None) -> Chain:
    from meshmark.attacks import parse_chain

    if strength is None:
        return parse_chain(name)
    if any(joint in name for joint in _JOINTS):
        raise InputError(
            f"STRENGTH {strength:g} follows a chain, expected strengths in it: crop:0.1+noise:0.003"
        )
    return parse_chain(f"{name}:{strength}")


def _check_needs(chain: Chain, others: list[Path]) -> None:
    if "embed" in chain.needs:
        raise InputError("second_mark needs a key, expected `meshmark embed IN OUT --key ANOTHER` instead")
    if chain.needs and not others:
        raise InputError(f"{chain} takes from other marked models, expected --with MODEL")


def _attacked(job: _Job, chain: Chain, seed: int) -> dict[str, Any]:
    import numpy as np

    from meshmark.attacks import Given
    from meshmark.io import check_extension, uncompressed, write_mesh

    check_extension(job.out, job.model)
    start = perf_counter()
    mesh = read_model(job.model, job.format, job.staging)
    copies = tuple(read_model(other, None, job.staging) for other in job.others)
    own = mesh.document.format if mesh.document else None
    with progress("attacking"), naming(named(job.model), *job.others), job.staging:
        result = chain.apply(
            mesh, np.random.default_rng(seed), Given(copies=copies, donor=next(iter(copies), None))
        )
        report = write_mesh(result.mesh, job.out, default=own, staging=job.staging)
        if job.map_out is not None:
            _write_map(result, job.map_out, job.staging)
    for remark in uncompressed(report, job.out):
        say(f"meshmark: {remark}")
    lost = _lost(mesh) if result.mesh.document is None else report.dropped
    if lost:
        say(f"meshmark: {job.out.name} does not hold the model's {', '.join(lost)}")
    return {
        "attack": str(chain),
        "seed": seed,
        "vertices": len(result.mesh.vertices),
        "vertices_before": len(mesh.vertices),
        "faces": len(result.mesh.faces),
        "faces_before": len(mesh.faces),
        "kept_vertices": None if result.origin is None else int((result.origin >= 0).sum()),
        "altered_vertices": None if result.altered is None else int(result.altered.sum()),
        "dropped": list(lost),
        "side_files": written_beside(job.staging, [job.out, job.map_out]),
        "seconds": perf_counter() - start,
    }


def _lost(mesh: Mesh) -> tuple[str, ...]:
    """Return the names of what a model's file holds beside positions and faces."""
    if mesh.document is None:
        return ()
    held = mesh.document.attributes()
    fields = {
        "normals": held.normals,
        "texture coordinates": held.texcoords,
        "vertex colours": held.colors,
    }
    return (*(word for word, values in fields.items() if values is not None), *held.other)


def _write_map(result: Attacked, path: Path, staging: Staging) -> None:
    import numpy as np

    count = len(result.mesh.vertices)
    origin = np.full(count, -1) if result.origin is None else result.origin
    altered = np.zeros(count, bool) if result.altered is None else result.altered
    rows = zip(range(count), origin.tolist(), altered.astype(int).tolist(), strict=True)
    lines = ["vertex,origin,altered", *(f"{vertex},{before},{edited}" for vertex, before, edited in rows)]
    staging.put(path, ("\n".join(lines) + "\n").encode("ascii"))


def _list(as_json: bool) -> None:
    from meshmark.attacks import ATTACKS

    entries = [
        {
            "name": name,
            "strengths": list(entry.strengths),
            "default": entry.default,
            "unit": entry.unit,
            "imitates": entry.imitates,
            "needs": entry.needs,
        }
        for name, entry in ATTACKS.items()
    ]
    answer("\n".join(_described(entry) for entry in entries), described({"attacks": entries}), as_json)


def _described(entry: dict[str, Any]) -> str:
    strengths = ", ".join(f"{strength:g}" for strength in entry["strengths"])
    default = f"; default {entry['default']:g}" if len(entry["strengths"]) > 1 else ""
    needs = {
        "": "",
        "copies": "; needs --with COPY for each copy",
        "donor": "; needs --with DONOR",
        "embed": "; on the command line: `meshmark embed` with another key",
    }[entry["needs"]]
    start, gap = f"{entry['name']:<{_INDENT}}", " " * _INDENT
    return f"{start}{strengths} ({entry['unit']}{default})\n{gap}{entry['imitates']}{needs}"

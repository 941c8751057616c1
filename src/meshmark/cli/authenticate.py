"""`meshmark authenticate`: was a model changed since it was marked, and where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson, CertificateIn, KeyFile, ModelIn, OriginalIn
from meshmark.cli.output import answer, say
from meshmark.cli.paths import check_output, naming
from meshmark.cli.progress import progress
from meshmark.cli.references import check_references, load_reference
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.mesh import Mesh
    from meshmark.schemes.ncdg_lv import Authentication

__all__ = ["VERDICT_CODES", "authenticate"]

VERDICT_CODES = {"authentic": 0, "altered": 1, "not_marked": 1, "inconclusive": 3}
_WORDS = {
    "authentic": "Authentic",
    "altered": "Altered",
    "not_marked": "Not marked",
    "inconclusive": "Inconclusive",
}


def authenticate(
    model: ModelIn,
    key: KeyFile,
    certificate: CertificateIn = None,
    original: OriginalIn = None,
    map_: Annotated[
        Path | None,
        typer.Option("--map", metavar="OUT.ply", help="Also write the model with its altered parts in red."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="OUT.html", help="Also write a page with pictures and a table.")
    ] = None,
    payload: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT", help="Also write the payload: the file as it was, or a miniature as a model."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Say whether, and where, a model was changed since marking.

    Neither the original nor a certificate is needed. Turning, resizing, another order of vertices and other
    formats are no changes. The map is a PLY with IN's vertices in their order, colours, and a property `altered`.

    Exit code 0: authentic; 1: altered, not marked with this key, or no payload to write; 3: inconclusive,
    or only the id is there, which does not tell whether the model was changed.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import read_mesh

    check_references(certificate, original)
    inputs = [path for path in (model, key, certificate, original) if path is not None]
    _check_outputs({map_: ".ply", report: ".html", payload: None}, inputs)
    secret = Key.load(key)
    mesh = read_mesh(model)
    reference = load_reference(certificate, original)
    from meshmark.schemes.ncdg_lv import authenticate as judge

    with progress("checking the marks"), naming(model):
        found = judge(mesh, secret, reference=reference)
    complete = _write(found, mesh, model, map_, report, payload)
    told = found.to_dict() if as_json else {}
    answer(f"{_WORDS[found.verdict]}: {model}. {found.advice}{_chance(found)}", told, as_json)
    return VERDICT_CODES[found.verdict] or (0 if complete else 1)


def _check_outputs(outputs: dict[Path | None, str | None], inputs: list[Path]) -> None:
    given = [path for path in outputs if path is not None]
    for path in given:
        check_output(path, inputs, outputs[path])
    if len({path.resolve() for path in given}) < len(given):
        raise InputError("two results are to go to one file, expected different names")


def _write(
    found: Authentication,
    mesh: Mesh,
    model: Path,
    map_: Path | None,
    report: Path | None,
    payload: Path | None,
) -> bool:
    """Write what is asked for, and return whether all of it was there."""
    if map_ is not None:
        from meshmark.report.tamper_map import write_tamper_map

        write_tamper_map(mesh, found.altered, map_)
    if report is not None:
        from meshmark.report.authentication import write_authentication_page

        with progress("drawing"):
            write_authentication_page(mesh, found, model.name, report)
    return payload is None or _write_payload(found, payload)


def _write_payload(found: Authentication, path: Path) -> bool:
    from meshmark.io import write_mesh
    from meshmark.io.whole import write_whole
    from meshmark.mesh import Mesh
    from meshmark.recovery.miniature import read_miniature

    if found.payload != "recovered" or found.content is None:
        why = {"partial": "too little of it is intact", "none": "the model carries none"}[found.payload]
        say(f"meshmark: {path} is not written: no payload was recovered, {why}")
        return False
    if found.content.kind == "miniature":
        write_mesh(Mesh(*read_miniature(found.content.content)), path)
    else:
        write_whole(path, found.content.content)
    return True


def _chance(found: Authentication) -> str:
    if found.verdict not in ("authentic", "altered"):
        return ""
    return f" Chance of such marks without the key below 10^{found.log10_false_positive:.0f}."

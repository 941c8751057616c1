"""`meshmark extract`: look for a mark."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson, CertificateIn, KeyFile, ModelIn, OriginalIn, Search
from meshmark.cli.output import answer
from meshmark.cli.paths import naming
from meshmark.cli.progress import progress
from meshmark.cli.references import check_references, load_reference

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.mesh import Mesh
    from meshmark.schemes.ncdg_lv import Extraction

__all__ = ["EXIT_CODES", "extract"]

EXIT_CODES = {"present": 0, "absent": 1, "inconclusive": 3}


def extract(
    model: ModelIn,
    key: KeyFile,
    certificate: CertificateIn = None,
    original: OriginalIn = None,
    search: Annotated[
        Search, typer.Option(help="quick is fast; wide spends more time on hard cases, such as crops.")
    ] = Search.quick,
    time_limit: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Give up after so long; without it, everything is tried."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Look for a mark, by the key alone or with a reference.

    Neither the original nor the id is needed, and IN may have been turned, resized, converted, roughened,
    smoothed or simplified. In a part of a model, or in a copy damaged more, the mark is found with the
    certificate that was made at embedding, or with the original.

    Exit code 0: present, and the id is printed; 1: absent; 3: inconclusive.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import read_mesh

    check_references(certificate, original)
    secret = Key.load(key)
    mesh = read_mesh(model)
    reference = load_reference(certificate, original)
    from meshmark.schemes.ncdg_lv import extract as find

    with progress("looking for the mark"), naming(model):
        found = find(mesh, secret, reference=reference, search=search.value, time_limit=time_limit)
        upper = _upper_layer(mesh, secret, found.mode == "blind") if found.presence == "absent" else ""
    if upper:
        found = replace(found, advice=f"No ownership mark was found, but {upper}")
    answer(_words(found, model, upper), found.to_dict(), as_json)
    return EXIT_CODES[found.presence]


def _upper_layer(mesh: Mesh, key: Key, blind: bool) -> str:
    """Return what to say of the authentication marks of a model, nothing where there are none of this key."""
    from meshmark.coding.message import format_id
    from meshmark.schemes.ncdg_lv.authentication.examination import told_by_marks

    identity = told_by_marks(mesh, key)
    if identity is None:
        return ""
    more = " In a part or a badly damaged copy the certificate or the original may find the ownership mark."
    return (
        f"authentication marks of this key are there, with the id {format_id(identity)}: "
        f"`meshmark authenticate` reads them.{more if blind else ''}"
    )


def _words(found: Extraction, model: Path, upper: str) -> str:
    from meshmark.coding.message import format_id

    if upper:
        return f"No ownership mark of this key in {model}, but {upper}"
    if found.id is not None:
        chance = f"chance of a false alarm below 10^{found.log10_false_positive:.0f}"
        return f"Present: {model} carries the id {format_id(found.id)}; {chance}. {found.advice}"
    start = {
        "present": f"Present in {model}, but the id cannot be read.",
        "absent": f"Absent from {model}.",
        "inconclusive": f"Inconclusive for {model}.",
    }[found.presence]
    return f"{start} {found.advice}"

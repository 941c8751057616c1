"""`meshmark embed`: put a mark into a model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.options import AsJson, KeyFile, ModelIn, ModelOut, Strength
from meshmark.cli.output import answer, percent, say
from meshmark.cli.paths import check_output
from meshmark.cli.progress import progress
from meshmark.errors import InputError

__all__ = ["embed"]

_LAYERS = "ownership"


def embed(
    model: ModelIn,
    out: ModelOut,
    key: KeyFile,
    identity: Annotated[
        str | None,
        typer.Option(
            "--id", metavar="HEX16", help="The id: 16 hexadecimal digits; without it, a random one."
        ),
    ] = None,
    strength: Annotated[
        Strength,
        typer.Option(help="RMS movement over the diagonal: subtle 0.02 %, standard 0.08 %, strong 0.2 %."),
    ] = Strength.standard,
    layers: Annotated[
        str, typer.Option(metavar="ownership", help="Layers to embed; this version has the ownership layer.")
    ] = _LAYERS,
    certificate: Annotated[
        Path | None,
        typer.Option(metavar="CERT", help="Also write a certificate, with which damaged copies are read."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Put a mark into a model.

    IN with an invisible 64-bit id goes to OUT; nothing but positions changes, and IN stays as it is.
    OUT appears only after it was read back and the id was found in it with the key alone.

    The certificate is a small file without the key or the surface. Keep it: with it, the mark is found in copies
    of which half is gone.
    """
    from meshmark.coding.keys import Key
    from meshmark.coding.message import format_id, parse_id
    from meshmark.schemes.ncdg_lv.files import embed_file

    if layers != _LAYERS:
        raise InputError(f"--layers {layers} is not available in this version, expected {_LAYERS}")
    check_output(out, [model, key])
    if certificate is not None:
        check_output(certificate, [model, key])
        if certificate.resolve() == out.resolve():
            raise InputError(f"{out} is to be the model and the certificate, expected two names")
    number = None if identity is None else parse_id(identity)
    secret = Key.load(key)
    with progress("marking"):
        result = embed_file(model, out, secret, number, strength.value, layers)
        if certificate is not None:
            result.certificate.save(certificate)
    for remark in result.remarks:
        say(f"meshmark: {remark}")
    rms, largest = percent(result.rms_over_diagonal), percent(result.max_over_diagonal)
    words = (
        f"Marked: {model} -> {out}; id {format_id(result.id)}; moved {rms} of the diagonal RMS "
        f"({largest} at most); read back and verified"
    )
    answer(words, result.to_dict(), as_json)
    return 0

"""`meshmark embed`: put a mark into a model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson, KeyFile, ModelIn, ModelOut, Strength
from meshmark.cli.output import answer, percent, plural, say
from meshmark.cli.paths import check_output
from meshmark.cli.progress import progress
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.schemes.ncdg_lv import Embedding

__all__ = ["embed", "marked_in_words"]

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
    as_json: AsJson = False,
) -> int:
    """Put a mark into a model: IN with an invisible 64-bit id goes to OUT, and nothing else changes.

    OUT appears only after it was read back and the id found in it with the key alone.
    """
    from meshmark.coding.keys import Key
    from meshmark.coding.message import parse_id
    from meshmark.schemes.ncdg_lv.files import embed_file

    if layers != _LAYERS:
        raise InputError(f"--layers {layers} is not available in this version, expected {_LAYERS}")
    check_output(out, [model, key])
    number = None if identity is None else parse_id(identity)
    secret = Key.load(key)
    with progress("marking"):
        result = embed_file(model, out, secret, id=number, strength=strength.value)
    for remark in result.remarks:
        say(f"meshmark: {remark}")
    answer(f"Marked: {model} -> {out}\n{marked_in_words(result)}", result.to_dict(), as_json)
    return 0

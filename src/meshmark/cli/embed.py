"""`meshmark embed`: put a mark into a model."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import (
    AsJson,
    Bits,
    ForceKeyed,
    KeyFile,
    Layers,
    ModelFormatIn,
    ModelIn,
    ModelOut,
    ReportOut,
    Strength,
    Tolerance,
)
from meshmark.cli.output import answer, described, percent, plural, say
from meshmark.cli.paths import naming, staged, written_beside
from meshmark.cli.progress import progress
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.cli.report_origin import written_origin
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.marking import Embedding

__all__ = ["embed"]


def embed(
    *,
    model: ModelIn,
    out: ModelOut,
    key: KeyFile,
    identity: Annotated[
        str | None,
        typer.Option(
            "--id",
            metavar="HEX16",
            help="The id: 16 hexadecimal digits, 8 with --bits 32; without it, a random one.",
        ),
    ] = None,
    bits: Annotated[
        Bits,
        typer.Option(
            help="Of the id. For models too small for 64: 32, as serial numbers of a registry have, or 0, a mark "
            "without an id, which says that it is there. With 32 and 0 there are no marks of authentication."
        ),
    ] = Bits.long,
    strength: Annotated[
        Strength,
        typer.Option(help="RMS movement over the diagonal: subtle 0.02 %, standard 0.08 %, strong 0.2 %."),
    ] = Strength.standard,
    layers: Annotated[
        Layers | None,
        typer.Option(
            help="ownership: an id that survives damage; authentication: tells what was changed later. "
            "Without this option both, or ownership alone where a model has no room for more."
        ),
    ] = None,
    payload: Annotated[
        str | None,
        typer.Option(
            metavar="miniature|none|FILE",
            help="What the authentication layer carries: a miniature of the model, for its recovery, or a file.",
        ),
    ] = None,
    tolerance: Annotated[
        Tolerance | None,
        typer.Option(
            help="strict: every change above the file's precision counts; tolerant: rounding to 16 bits does not; "
            "web: rounding to 14 bits, as web pipelines do, does not; default: rounding to six digits does not, "
            "where there is room. A tolerance that is asked for is kept, or the model refused; without this "
            "option, web for glTF where there is room, else default, or the id alone where marks do not fit."
        ),
    ] = None,
    certificate: Annotated[
        Path | None,
        typer.Option(metavar="CERT", help="Also write a certificate, with which damaged copies are read."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.png", help="Also draw the original, the marked model, and the change of its shading."
        ),
    ] = None,
    report: ReportOut = None,
    recipient: Annotated[
        str | None,
        typer.Option(
            "--to", metavar="NAME", help="To whom the copy goes; kept in the registry, not in the file."
        ),
    ] = None,
    registry: RegistryIn = None,
    recompress: Annotated[
        bool,
        typer.Option(
            "--recompress",
            help="Compress OUT as IN is (glTF with Draco); without it, OUT of a compressed glTF is uncompressed.",
        ),
    ] = False,
    format: ModelFormatIn = None,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Put a mark into a model.

    IN with an invisible 64-bit id, and marks that tell what was changed later, goes to OUT; nothing but
    positions changes, and IN stays as it is. OUT and the certificate appear together, after OUT was read back
    with the key alone.

    The certificate is a small file without the key or the surface. Keep it: with it, the mark is found in copies
    of which half is gone, and with the key it takes the mark off again.

    With --registry the copy is entered into a registry, with its certificate: no file has a name without its row.

    A model too small for 64 bits carries 32, or a mark without an id, where --bits asks for it; the refusal of 64
    says which of them would fit.

    Exit code 4: the model cannot carry what was asked, and nothing is written.
    """
    from meshmark.coding.keys import Key
    from meshmark.coding.message import parse_id

    carried = payload if payload in (None, "miniature", "none") else Path(str(payload))
    inputs = [model, key, carried if isinstance(carried, Path) else None]
    staging = staged([(out, None), (certificate, None), (picture, ".png"), (report, ".html")], inputs, force)
    length = int(bits)
    number = None if identity is None else parse_id(identity, length)
    if registry and not length:
        raise InputError("a registry tells copies by their ids, expected --bits 64 or 32 with --registry")
    if recipient is not None and not registry:
        raise InputError("--to is kept in a registry, expected --registry as well")
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    from meshmark.marking.marked_file import embed_file

    wanted = None if layers is None else layers.value
    coarse = None if tolerance is None else tolerance.value
    with ExitStack() as stack:
        stack.enter_context(progress("marking"))
        stack.enter_context(naming(named(model)))
        entry = None
        if registry:
            from meshmark.registry.entering import original_of_mesh
            from meshmark.registry.recording import recorded

            opened = stack.enter_context(open_registry(registry))
            original = original_of_mesh(mesh, named(model).name, opened)
            entry = stack.enter_context(
                recorded(opened, original, secret, out, id=number, bits=length, recipient=recipient)
            )
            number = entry.id
        stack.enter_context(staging)
        result = embed_file(
            mesh,
            out,
            secret,
            id=number,
            bits=length,
            strength=strength.value,
            layers=wanted,
            payload=carried,
            tolerance=coarse,
            recompress=recompress,
            staging=staging,
        )
        if certificate is not None:
            result.certificate.save(certificate, staging)
        if picture is not None:
            from meshmark.report.shading_change import shading_picture

            shading_picture(mesh, result.mesh, picture, staging=staging)
        if report is not None:
            from meshmark.report.embedding_page import write_embedding_page

            origin = written_origin(staging, out, secret)
            write_embedding_page(mesh, result, origin, report, staging)
        if entry is not None:
            entry.complete(result, staging.staged(out))
    for remark in result.remarks:
        say(f"meshmark: {remark}")
    fields = {**result.to_dict(), "side_files": written_beside(staging, [out, certificate, picture, report])}
    if entry is not None:
        fields["recipient"] = recipient
    outputs = {"model": out, "certificate": certificate, "picture": picture, "report": report}
    answer(_words(result, named(model), out), described(fields, model, outputs, secret), as_json)
    return 0


def _words(result: Embedding, model: Path, out: Path) -> str:
    from meshmark.coding.message import format_id

    rms, largest = percent(result.rms_over_diagonal), percent(result.max_over_diagonal)
    identity = "no id" if result.id is None else f"id {format_id(result.id)}"
    upper = ""
    if result.mark_vertices:
        payload = f" with {plural(result.payload_bytes, 'byte')} of payload" if result.payload_bytes else ""
        upper = f"; {plural(result.mark_vertices, 'mark')} of authentication{payload}"
    return (
        f"Marked: {model} -> {out}; {identity}; moved {rms} of the diagonal RMS "
        f"({largest} at most){upper}; read back and verified"
    )

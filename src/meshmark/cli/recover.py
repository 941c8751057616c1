"""`meshmark recover`: bring back what was altered."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import (
    AsJson,
    CertificateIn,
    ForceKeyed,
    KeyFile,
    ModelFormatIn,
    ModelIn,
    ModelOut,
)
from meshmark.cli.output import answer, described, percent, plural, say
from meshmark.cli.paths import naming, staged, written_beside
from meshmark.cli.progress import progress
from meshmark.cli.references import load_reference

__all__ = ["recover"]

_Original = Annotated[
    Path | None,
    typer.Option(
        "--original",
        metavar="MODEL",
        help="The unmarked original: parts come back vertex for vertex. With --certificate it takes less time.",
    ),
]


def recover(
    *,
    model: ModelIn,
    out: ModelOut,
    key: KeyFile,
    certificate: CertificateIn = None,
    original: _Original = None,
    format: ModelFormatIn = None,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Bring back what was altered in a marked model.

    The intact part carries a miniature of the whole: moved parts return to it, foreign ones are cut out, holes are
    filled. With the original, altered vertices return to where they were signed off, and what is gone comes back.
    All else stays as it is. Where nothing was altered OUT is a copy of IN.

    Exit code 1: it cannot be recovered, and nothing is written.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import check_extension, uncompressed, write_mesh

    staging = staged([(out, None)], [model, key, certificate, original], force)
    check_extension(out, model)
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    reference = load_reference(certificate)
    source = None if original is None else read_model(original, None, staging)
    from meshmark.marking import recover as bring_back

    with progress("recovering"), naming(named(model)):
        found = bring_back(mesh, secret, reference=reference, original=source)
    if found.mesh is None:
        fields = described(found.to_dict(), model, key=secret)
        answer(f"Not recovered: {named(model)}. {found.advice}", fields, as_json)
        return 1
    if found.lost:
        say(f"meshmark: {out.name} will not hold the model's {', '.join(found.lost)}: its faces change")
    with staging:
        report = write_mesh(found.mesh, out, staging=staging)
    for remark in uncompressed(report, out):
        say(f"meshmark: {remark}")
    if report.dropped:
        say(f"meshmark: {out.name} cannot hold the model's {', '.join(report.dropped)}")
    words = (
        f"Recovered: {named(model)} -> {out}; {percent(found.altered_area_fraction)} of the surface was altered; "
        f"{plural(found.vertices_moved, 'vertex/vertices')} moved, "
        f"{plural(found.vertices_removed, 'vertex/vertices')} cut out, {plural(found.faces_added, 'face')} added. "
        f"{found.advice}"
    )
    fields = {**found.to_dict(), "side_files": written_beside(staging, [out])}
    answer(words, described(fields, model, {"model": out}, secret), as_json)
    return 0

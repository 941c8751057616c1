"""`meshmark recover`: bring back what was altered."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

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
    ReportOut,
)
from meshmark.cli.output import answer, described, percent, plural, say
from meshmark.cli.paths import naming, staged, written_beside
from meshmark.cli.progress import progress
from meshmark.cli.references import load_reference
from meshmark.cli.registry_option import open_registry
from meshmark.cli.report_origin import written_origin
from meshmark.coding.message import format_id
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.io import Staging
    from meshmark.marking import Authentication, Recovery
    from meshmark.mesh import Mesh
    from meshmark.registry.registry import Registry
    from meshmark.report.provenance import Provenance

__all__ = ["recover"]

_Original = Annotated[
    Path | None,
    typer.Option(
        "--original",
        metavar="MODEL",
        help="The unmarked original: parts come back vertex for vertex. With --certificate it takes less time.",
    ),
]

_Registry = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        help="Registry of copies, whose file of the marked copy parts come from; no variable stands in for it.",
    ),
]


def recover(
    *,
    model: ModelIn,
    out: ModelOut,
    key: KeyFile,
    certificate: CertificateIn = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.png", help="Also draw IN, what was altered in it, and the recovered model."
        ),
    ] = None,
    report: ReportOut = None,
    original: _Original = None,
    registry: _Registry = None,
    format: ModelFormatIn = None,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Bring back what was altered in a marked model.

    The intact part carries a miniature of the whole: moved parts return to it, foreign ones are cut out, holes are
    filled. With the original, altered vertices return to where they were signed off, and what is gone comes back.
    All else stays as it is. Where nothing was altered OUT is a copy of IN. With --registry they come from the file
    of the marked copy, which has to be where it was written.

    Exit code 1: it cannot be recovered, and nothing is written.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import check_extension, uncompressed, write_mesh

    if registry and original is not None:
        raise InputError("--original and --registry exclude each other, expected one of them")
    staging = staged(
        [(out, None), (picture, ".png"), (report, ".html")], [model, key, certificate, original], force
    )
    check_extension(out, model)
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    reference = load_reference(certificate)
    source = None if original is None else read_model(original, None, staging)
    copy = None
    if registry:
        with progress("looking for the copy"), naming(named(model)), open_registry(registry) as opened:
            copy = _marked_copy(mesh, secret, opened, staging)
    from meshmark.marking import authenticate as judge
    from meshmark.marking import recover as bring_back

    with progress("recovering"), naming(named(model)):
        found = bring_back(mesh, secret, reference=reference, original=source, copy=copy)
    if found.mesh is None:
        fields = described(found.to_dict(), model, key=secret)
        answer(f"Not recovered: {named(model)}. {found.advice}", fields, as_json)
        return 1
    if found.lost:
        say(f"meshmark: {out.name} will not hold the model's {', '.join(found.lost)}: its faces change")
    with staging:
        saved = write_mesh(found.mesh, out, staging=staging)
        if picture is not None or report is not None:
            with progress("drawing"):
                before = judge(mesh, secret, reference=reference)
                origin = written_origin(staging, out, secret, certificate=certificate, original=original)
                _show(_Shown(mesh, before, found, origin), picture, report, staging)
    for remark in uncompressed(saved, out):
        say(f"meshmark: {remark}")
    if saved.dropped:
        say(f"meshmark: {out.name} cannot hold the model's {', '.join(saved.dropped)}")
    words = (
        f"Recovered: {named(model)} -> {out}; {percent(found.altered_area_fraction)} of the surface was altered, "
        f"the rest is as signed off; "
        f"{plural(found.vertices_moved, 'vertex/vertices')} moved, "
        f"{plural(found.vertices_removed, 'vertex/vertices')} cut out, {plural(found.faces_added, 'face')} added. "
        f"{found.advice}"
    )
    fields = {**found.to_dict(), "side_files": written_beside(staging, [out, picture, report])}
    answer(
        words, described(fields, model, {"model": out, "picture": picture, "report": report}, secret), as_json
    )
    return 0


def _marked_copy(mesh: Mesh, key: Key, registry: Registry, staging: Staging) -> Mesh:
    """Return the marked copy of the registry that a suspect was; raises `InputError` where it is not there."""
    from meshmark.io.file_digest import digest_of_file
    from meshmark.registry.copy_of import copy_of

    found = copy_of(mesh, key, registry)
    if found is None:
        raise InputError(
            "the registry names no single copy that the model was, expected --original MODEL instead"
        )
    path = None if found.path is None else Path(found.path)
    if path is None or not path.is_file():
        where = "not known" if path is None else f"no longer {path}"
        raise InputError(
            f"the file of the copy with the id {format_id(found.id)} is {where}, expected --original MODEL instead"
        )
    if digest_of_file(path) != found.marked_digest:
        raise InputError(
            f"{path} was changed since it was marked, expected --original MODEL instead", file=path
        )
    return read_model(path, None, staging)


class _Shown(NamedTuple):
    """What pictures and pages of a recovery show."""

    suspect: Mesh
    found: Authentication
    made: Recovery
    origin: Provenance


def _show(shown: _Shown, picture: Path | None, report: Path | None, staging: Staging) -> None:
    """Draw the picture and write the page of a recovery that has a mesh."""
    from meshmark.report.recovery_page import recovery_report
    from meshmark.report.recovery_triptych import recovery_triptych
    from meshmark.report.report_page import write_report_page

    if picture is not None and shown.made.mesh is not None:
        recovery_triptych(shown.suspect, shown.found, shown.made.mesh, picture, staging=staging)
    if report is not None:
        write_report_page(recovery_report(*shown), report, staging)

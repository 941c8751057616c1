"""`meshmark authenticate`: was a model changed since it was marked, and where."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import (
    AsJson,
    CertificateIn,
    Diagnose,
    ForceKeyed,
    KeyFile,
    ModelFormatIn,
    ModelIn,
    OriginalIn,
    ReportOut,
)
from meshmark.cli.output import answer, described, say
from meshmark.cli.paths import naming, staged
from meshmark.cli.progress import progress
from meshmark.cli.references import check_references, load_reference
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.cli.report_origin import report_origin

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.io import Staging
    from meshmark.marking import Authentication, Certificate
    from meshmark.mesh import Mesh
    from meshmark.registry.registry import Registry
    from meshmark.report.provenance import Provenance

__all__ = ["VERDICT_CODES", "authenticate"]

VERDICT_CODES = {"authentic": 0, "surface_intact": 3, "altered": 1, "not_marked": 1, "inconclusive": 3}
_WORDS = {
    "authentic": "Authentic",
    "surface_intact": "Surface intact, but the file shows something else",
    "altered": "Altered",
    "not_marked": "Not marked",
    "inconclusive": "Inconclusive",
}


def authenticate(
    *,
    model: ModelIn,
    key: KeyFile,
    certificate: CertificateIn = None,
    original: OriginalIn = None,
    registry: RegistryIn = None,
    map_: Annotated[
        Path | None,
        typer.Option("--map", metavar="OUT.ply", help="Also write the model with its altered parts in red."),
    ] = None,
    report: ReportOut = None,
    payload: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT", help="Also write the payload: the file as it was, or a miniature as a model."
        ),
    ] = None,
    format: ModelFormatIn = None,
    diagnose: Diagnose = False,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Say whether, and where, a model was changed since marking.

    Neither the original nor a certificate is needed. Turning, resizing, another order of vertices and other
    formats are no changes. The map is a PLY with IN's vertices in their order, colours, and a property `altered`.
    With --registry the recipient of the copy is named, and its certificate is looked up where no marks are found.

    Exit code 0: authentic; 1: altered, not marked with this key, or no payload to write; 3: the surface is intact
    but the file shows something else (morph weights, a pose, another scene, hidden faces), or inconclusive: only
    the id is there, which does not tell whether the model was changed.
    """
    from meshmark.coding.keys import Key

    check_references(certificate, original)
    outputs = [(map_, ".ply"), (report, ".html"), (payload, None)]
    staging = staged(outputs, [model, key, certificate, original], force)
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    reference = load_reference(certificate, original, staging)
    recipient = None
    with ExitStack() as stack:
        stack.enter_context(progress("checking the marks"))
        stack.enter_context(naming(named(model)))
        if registry:
            opened = stack.enter_context(open_registry(registry))
            found, recipient = _registered(mesh, secret, reference, opened)
        else:
            from meshmark.marking import authenticate as judge

            found = judge(mesh, secret, reference=reference)
    with staging:
        if map_ is not None:
            _write_map(mesh, found, map_, staging)
        if report is not None:
            origin = report_origin(mesh, model, secret, certificate=certificate, original=original)
            _write_page(mesh, found, origin, report, staging)
        complete = payload is None or _write_payload(found, payload, staging)
    issued = "" if recipient is None else f" The copy was issued to {recipient}."
    answer(
        f"{_WORDS[found.verdict]}: {named(model)}. {found.advice}{issued}{_chance(found, diagnose)}",
        described(
            {**found.to_dict(diagnose=diagnose), "recipient": recipient} if as_json else {},
            model,
            {"map": map_, "report": report, "payload": payload if complete else None},
            secret,
        ),
        as_json,
    )
    return VERDICT_CODES[found.verdict] or (0 if complete else 1)


def _registered(
    mesh: Mesh, key: Key, reference: Certificate | Mesh | None, registry: Registry
) -> tuple[Authentication, str | None]:
    """Return what the marks say, and to whom the copy went.

    Where no marks are found the certificate of the copy tells whether there were some.
    """
    from meshmark.marking import authenticate as judge
    from meshmark.registry.copy_of import certificate_of, copy_of

    found = judge(mesh, key, reference=reference)
    if reference is None and found.verdict in ("not_marked", "inconclusive"):
        identity = found.id
        if identity is None:
            copy = copy_of(mesh, key, registry)
            identity = None if copy is None else copy.id
        certificate = None if identity is None else certificate_of(identity, key, registry)
        if certificate is not None:
            found = judge(mesh, key, reference=certificate)
    recipients = () if found.id is None else registry.recipients([found.id], key.fingerprint)
    return found, next(iter(recipients), None)


def _write_map(mesh: Mesh, found: Authentication, path: Path, staging: Staging) -> None:
    from meshmark.report.tamper_map import write_tamper_map

    write_tamper_map(mesh, found.altered, path, staging)


def _write_page(mesh: Mesh, found: Authentication, origin: Provenance, path: Path, staging: Staging) -> None:
    from meshmark.report.authentication_page import write_authentication_page

    with progress("drawing"):
        write_authentication_page(mesh, found, origin, path, staging)


def _write_payload(found: Authentication, path: Path, staging: Staging) -> bool:
    """Write the payload, and return whether there was one."""
    from meshmark.io import write_mesh
    from meshmark.mesh import Mesh
    from meshmark.recovery.miniature import read_miniature

    if found.payload != "recovered" or found.content is None:
        why = {"partial": "too little of it is intact", "none": "the model carries none"}[found.payload]
        say(f"meshmark: {path} is not written: no payload was recovered, {why}")
        return False
    if found.content.kind == "miniature":
        write_mesh(Mesh(*read_miniature(found.content.content)), path, staging=staging)
    else:
        staging.put(path, found.content.content)
    return True


def _chance(found: Authentication, diagnose: bool) -> str:
    from meshmark.coding.chance import band, in_words

    if found.verdict not in ("authentic", "surface_intact", "altered"):
        return ""
    bound = found.log10_false_positive if diagnose else band(found.log10_false_positive)
    return f" Chance of such marks without the key {in_words(bound)}."

"""`meshmark extract`: look for a mark."""

from __future__ import annotations

from collections.abc import Sequence
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
    Search,
)
from meshmark.cli.output import answer, described
from meshmark.cli.paths import naming, staged
from meshmark.cli.progress import progress
from meshmark.cli.references import check_references, load_ids, load_reference
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.cli.report_origin import report_origin

if TYPE_CHECKING:
    from meshmark.marking import Extraction

__all__ = ["EXIT_CODES", "extract"]

EXIT_CODES = {"present": 0, "absent": 1, "inconclusive": 3}


def extract(
    *,
    model: ModelIn,
    key: KeyFile,
    certificate: CertificateIn = None,
    original: OriginalIn = None,
    search: Annotated[
        Search, typer.Option(help="quick is fast; wide spends more time on hard cases, such as crops.")
    ] = Search.quick,
    among: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Ids of which one may be there, 16 (or 8) hexadecimal digits a line; # starts a comment.",
        ),
    ] = None,
    registry: RegistryIn = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", help="Stop after this many seconds; without it, everything is tried."
        ),
    ] = None,
    report: ReportOut = None,
    format: ModelFormatIn = None,
    diagnose: Diagnose = False,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Look for a mark, by the key alone or with a reference.

    Neither the original nor the id is needed, and IN may have been turned, resized, converted, roughened,
    smoothed or simplified. In a part of a model, or in a copy damaged more, the mark is found with the
    certificate that was made at embedding, or with the original. Where the authentication marks alone are left, as
    in a part of a model, they tell the id; where parts of IN carry different ids, all are named. Less of a mark is
    enough where the ids that were given out are listed with --among, and an average of copies names those of them
    that it was made of; without the list, of two copies only. With --registry the certificates and ids of likely
    originals are looked up there, and the recipient is named.

    Exit code 0: present, and the id is printed, or the ids where there are several; 1: absent; 3: inconclusive.
    """
    from meshmark.coding.keys import Key

    check_references(certificate, original)
    staging = staged([(report, ".html")], [model, key, certificate, original, among], force)
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    reference = load_reference(certificate, original, staging)
    ids = () if among is None else load_ids(among)
    with ExitStack() as stack:
        stack.enter_context(progress("looking for the mark"))
        stack.enter_context(naming(named(model)))
        opened = stack.enter_context(open_registry(registry)) if registry else None
        if opened is not None and reference is None and not ids:
            from meshmark.registry.tracing import trace

            traced = trace(mesh, secret, opened, search=search.value, time_limit=time_limit)
            found, recipients = traced.extraction, [each.recipient for each in traced.matches]
        else:
            from meshmark.marking import extract as find

            found = find(
                mesh, secret, reference=reference, search=search.value, time_limit=time_limit, among=ids
            )
            recipients = [] if opened is None else opened.recipients(found.ids, secret.fingerprint)
    named_ones = [each for each in recipients if each is not None]
    if report is not None:
        origin = report_origin(mesh, model, secret, certificate=certificate, original=original)
        from meshmark.report.extraction_page import write_extraction_page

        with progress("drawing"), staging:
            write_extraction_page(mesh, found, origin, report, recipients=named_ones, staging=staging)
    fields = described(found.to_dict(diagnose=diagnose), model, {"report": report}, secret)
    fields["recipient"] = named_ones[0] if len(recipients) == 1 and named_ones else None
    fields["recipients"] = named_ones
    answer(_words(found, named(model), diagnose, named_ones), fields, as_json)
    return EXIT_CODES[found.presence]


def _words(found: Extraction, model: Path, diagnose: bool, recipients: Sequence[str]) -> str:
    from meshmark.coding.chance import band, in_words
    from meshmark.coding.message import format_id

    if found.ids:
        bound = found.log10_false_positive if diagnose else band(found.log10_false_positive)
        chance = f"chance of a false alarm {in_words(bound)}"
        *first, last = map(format_id, found.ids)
        ids = f"the ids {', '.join(first)} and {last}" if first else f"the id {last}"
        issued = f", issued to {', '.join(recipients)}" if recipients else ""
        return f"Present: {model} carries {ids}{issued}; {chance}. {found.advice}"
    if found.bits == 0:
        bound = found.log10_false_positive if diagnose else band(found.log10_false_positive)
        return (
            f"Present: {model} carries a mark of this key, without an id; chance of a false alarm "
            f"{in_words(bound)}. {found.advice}"
        )
    start = {
        "present": f"Present in {model}, but the id cannot be read.",
        "absent": f"Absent from {model}.",
        "inconclusive": f"Inconclusive for {model}.",
    }[found.presence]
    return f"{start} {found.advice}"

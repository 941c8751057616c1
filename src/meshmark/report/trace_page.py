"""The report of a trace: whose copy a model is, by a registry, and how sure that is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from meshmark.coding.chance import in_words
from meshmark.coding.message import format_id
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh
from meshmark.report.extraction_page import extraction_report
from meshmark.report.provenance import Provenance
from meshmark.report.report_page import Report, Table, write_report_page

if TYPE_CHECKING:
    from meshmark.registry.tracing import Trace

__all__ = ["trace_report", "write_trace_page"]

_METHODS: Final = {
    "blind": "with the key alone",
    "authentication": "from its authentication marks",
    "registered": "by the certificate of its original",
}
_COLUMNS = ("Recipient", "Id", "Original", "Read", "Chance to name an innocent recipient")


def write_trace_page(
    mesh: Mesh, found: Trace, origin: Provenance, path: Path | str, staging: Staging | None = None
) -> None:
    """Save the page of a trace; raises `OutputError` where it cannot be written.

    staging: takes the file, to move it into place together with others.
    """
    write_report_page(trace_report(mesh, found, origin), path, staging)


def trace_report(mesh: Mesh, found: Trace, origin: Provenance) -> Report:
    """Return what the page of a trace says: what that of an extraction does, with the recipients before it."""
    recipients = list(dict.fromkeys(each.recipient for each in found.matches if each.recipient is not None))
    report = extraction_report(mesh, found.extraction, origin, recipients)
    if not found.matches:
        return replace(report, kind="Trace", heading="It names no recipient", tone="open")
    rows = tuple(
        (
            each.recipient or "none named",
            format_id(each.id),
            each.original,
            _METHODS[each.method],
            in_words(each.log10_false_accusation).replace("^-", "^−"),
        )
        for each in found.matches
    )
    named = ", ".join(recipients) if recipients else "a recipient without a name"
    return replace(
        report,
        kind="Trace",
        answer="present",
        tone="good",
        heading=f"The copy of {named}",
        tables=[Table(title="Whose copy", columns=_COLUMNS, rows=rows, words=4), *report.tables],
    )

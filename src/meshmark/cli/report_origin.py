"""What a report says of where it comes from, as a command line tells it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.model_input import named

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.io import Staging
    from meshmark.mesh import Mesh
    from meshmark.report.provenance import Provenance

__all__ = ["report_origin", "written_origin"]


def report_origin(
    mesh: Mesh, model: Path, key: Key, *, certificate: Path | None = None, original: Path | None = None
) -> Provenance:
    """Return the provenance of a report about a model that was read from a file, or from standard input."""
    from meshmark.io import input_files
    from meshmark.report.provenance import provenance

    reference = _reference(certificate, original)
    files = {path.name: path for path in (model, *input_files(mesh))}
    return provenance(named(model).name, files, key.fingerprint, reference)


def written_origin(
    staging: Staging, out: Path, key: Key, *, certificate: Path | None = None, original: Path | None = None
) -> Provenance:
    """Return the provenance of a report about a model that a command writes, while its files are being staged."""
    from meshmark.report.provenance import provenance

    files = {out.name: staging.staged(out)}
    return provenance(out.name, files, key.fingerprint, _reference(certificate, original))


def _reference(certificate: Path | None, original: Path | None) -> str:
    """Return what helped to read the mark, in words; empty for the key alone."""
    named_ones = [
        *([] if certificate is None else [f"the certificate {certificate.name}"]),
        *([] if original is None else [f"the original {original.name}"]),
    ]
    return ", ".join(["the key", *named_ones]) if named_ones else ""

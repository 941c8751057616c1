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

    reference = ""
    if certificate is not None:
        reference = f"the key and the certificate {certificate.name}"
    if original is not None:
        reference = f"the key and the original {original.name}"
    files = {path.name: path for path in (model, *input_files(mesh))}
    return provenance(named(model).name, files, key.fingerprint, reference)


def written_origin(staging: Staging, out: Path, key: Key, *, certificate: Path | None = None) -> Provenance:
    """Return the provenance of a report about a model that a command writes, while its files are being staged."""
    from meshmark.report.provenance import provenance

    reference = "" if certificate is None else f"the key and the certificate {certificate.name}"
    return provenance(out.name, {out.name: staging.staged(out)}, key.fingerprint, reference)

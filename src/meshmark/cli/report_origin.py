"""What a report says of where it comes from, as a command line tells it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.model_input import named

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.mesh import Mesh
    from meshmark.report.provenance import Provenance

__all__ = ["report_origin"]


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
    return provenance(named(model).name, [model, *input_files(mesh)], key.fingerprint, reference)

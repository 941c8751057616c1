"""What a command may be given about a model besides the key: its certificate, or the original."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.model_input import read_model
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.io import Staging
    from meshmark.marking import Certificate
    from meshmark.mesh import Mesh

__all__ = ["check_references", "load_reference"]


def check_references(certificate: Path | None, original: Path | None) -> None:
    """Raise `InputError` where both are given."""
    if certificate is not None and original is not None:
        raise InputError("--certificate and --original exclude each other, expected one of them")


def load_reference(
    certificate: Path | None, original: Path | None = None, staging: Staging | None = None
) -> Certificate | Mesh | None:
    """Return what the file of the one that is given holds, None without any.

    staging: of the outputs, which must not touch the files of the original.
    """

    if certificate is not None:
        from meshmark.marking import Certificate

        return Certificate.load(certificate)
    return None if original is None else read_model(original, None, staging)

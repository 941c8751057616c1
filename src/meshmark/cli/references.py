"""What a command may be given about a model besides the key: its certificate, the original, ids given out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.model_input import read_model
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.io import Staging
    from meshmark.marking import Certificate
    from meshmark.mesh import Mesh

__all__ = ["check_references", "load_ids", "load_reference"]


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


def load_ids(path: Path) -> tuple[int, ...]:
    """Return the ids of a text file, one a line; blank lines are skipped, # starts a comment.

    Raises `InputError` where the file cannot be read, holds no id, or a line is something else.
    """
    from meshmark.coding.message import parse_id

    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except OSError as error:
        raise InputError(f"cannot read the ids in {path}: {error.strerror or 'error'}", file=path) from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path} is no text, expected one id of 16 hexadecimal digits a line", file=path
        ) from None
    ids = []
    for number, line in enumerate(lines, start=1):
        if text := line.partition("#")[0].strip():
            try:
                ids.append(parse_id(text))
            except InputError as error:
                raise InputError(f"{path}, line {number}: {error}", file=path) from None
    if not ids:
        raise InputError(f"{path} lists no ids, expected one of 16 hexadecimal digits a line", file=path)
    return tuple(ids)

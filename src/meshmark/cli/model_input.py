"""The model that a command is given: a file, or standard input where its format is given."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.paths import STANDARD_INPUT
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.cli.options import ModelFormat
    from meshmark.io import Staging
    from meshmark.mesh import Mesh

__all__ = ["named", "read_model"]


def read_model(path: Path, format: ModelFormat | None, staging: Staging | None = None) -> Mesh:
    """Read a model file, or standard input for `-`; raises `InputError`.

    format: of standard input, which has no name and need not tell by its content; None for a file.
    staging: of the outputs, which must not touch the files that the model is made of.
    """
    from meshmark.io import input_files

    mesh = _read(path, format)
    if staging is not None:
        staging.keep(*input_files(mesh))
    return mesh


def _read(path: Path, format: ModelFormat | None) -> Mesh:
    from meshmark.io import read_mesh, read_mesh_from

    if path != STANDARD_INPUT:
        if format is not None:
            raise InputError(
                f"--format {format.value} is for standard input, but IN is {path}, which tells its own format",
                file=path,
            )
        return read_mesh(path)
    if format is None:
        raise InputError(
            "a model on standard input has no name to tell its format, expected --format", file=path
        )
    return read_mesh_from(sys.stdin.buffer, format.value)


def named(path: Path) -> Path:
    """Return what to call a model in words."""
    return Path("standard input") if path == STANDARD_INPUT else path

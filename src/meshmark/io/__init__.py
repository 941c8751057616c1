"""Files to meshes and back: a save patches positions into the original bytes and changes nothing else."""

from __future__ import annotations

from meshmark.io.formats import FORMATS, check_extension
from meshmark.io.save import (
    WriteReport,
    check_recompression,
    conform,
    input_files,
    uncompressed,
    write_mesh,
)
from meshmark.io.source import read_mesh, read_mesh_from
from meshmark.io.staging import Staging

__all__ = [
    "FORMATS",
    "Staging",
    "WriteReport",
    "check_extension",
    "check_recompression",
    "conform",
    "input_files",
    "read_mesh",
    "read_mesh_from",
    "uncompressed",
    "write_mesh",
]

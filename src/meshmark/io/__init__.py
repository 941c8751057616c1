"""Files to meshes and back: a save patches positions into the original bytes and changes nothing else."""

from __future__ import annotations

from meshmark.io.formats import FORMATS
from meshmark.io.save import WriteReport, conform, input_files, write_mesh
from meshmark.io.source import read_mesh, read_mesh_from
from meshmark.io.staging import Staging

__all__ = [
    "FORMATS",
    "Staging",
    "WriteReport",
    "conform",
    "input_files",
    "read_mesh",
    "read_mesh_from",
    "write_mesh",
]

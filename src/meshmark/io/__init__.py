"""Files to meshes and back: a save patches positions into the original bytes and changes nothing else."""

from __future__ import annotations

from meshmark.io.formats import FORMATS, check_extension
from meshmark.io.save import WriteReport, check_recompression, conform, uncompressed, write_mesh
from meshmark.io.source import read_mesh

__all__ = [
    "FORMATS",
    "WriteReport",
    "check_extension",
    "check_recompression",
    "conform",
    "read_mesh",
    "uncompressed",
    "write_mesh",
]

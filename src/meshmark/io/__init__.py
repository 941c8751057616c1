"""Files to meshes and back: a save patches positions into the original bytes and changes nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.late import late_names

if TYPE_CHECKING:
    from meshmark.io.file_precision import conform
    from meshmark.io.formats import FORMATS, check_extension
    from meshmark.io.save import (
        WriteReport,
        check_recompression,
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

_HOME = {
    "FORMATS": "io.formats",
    "Staging": "io.staging",
    "WriteReport": "io.save",
    "check_extension": "io.formats",
    "check_recompression": "io.save",
    "conform": "io.file_precision",
    "input_files": "io.save",
    "read_mesh": "io.source",
    "read_mesh_from": "io.source",
    "uncompressed": "io.save",
    "write_mesh": "io.save",
}

__getattr__ = late_names(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)

"""Invisible, key-protected watermarks in the geometry of 3D models.

    import meshmark as mm

    key = mm.Key.generate()
    marked = mm.embed(mm.read_mesh("hare.ply"), key)
    mm.write_mesh(marked.mesh, "marked.ply")
    found = mm.extract(mm.read_mesh("marked.ply"), key)
    check = mm.authenticate(mm.read_mesh("marked.ply"), key)

`mm.embed_file` goes from file to file and verifies what it has written. The names below are the public interface.
Each is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.kernels import same_on_every_processor
from meshmark.late import late_names

if TYPE_CHECKING:
    from meshmark.attacks import ATTACKS
    from meshmark.coding.keys import Key
    from meshmark.errors import (
        CapacityError,
        FormatError,
        InputError,
        KeyFileError,
        MeshmarkError,
        OutputError,
    )
    from meshmark.io import read_mesh, write_mesh
    from meshmark.marking import (
        Authentication,
        Certificate,
        Embedding,
        Extraction,
        Recovery,
        Unmarked,
        authenticate,
        embed,
        embed_file,
        extract,
        recover,
        unmark,
    )
    from meshmark.mesh import Mesh
    from meshmark.metrics import METRICS, compare
    from meshmark.saliency import analyse
    from meshmark.segmentation import segment

__all__ = [
    "ATTACKS",
    "METRICS",
    "Authentication",
    "CapacityError",
    "Certificate",
    "Embedding",
    "Extraction",
    "FormatError",
    "InputError",
    "Key",
    "KeyFileError",
    "Mesh",
    "MeshmarkError",
    "OutputError",
    "Recovery",
    "Unmarked",
    "analyse",
    "authenticate",
    "compare",
    "embed",
    "embed_file",
    "extract",
    "read_mesh",
    "recover",
    "segment",
    "unmark",
    "write_mesh",
]

__version__ = "0.1.0"

_HOME = {
    "ATTACKS": "attacks",
    "METRICS": "metrics",
    "Authentication": "authentication.verdict",
    "CapacityError": "errors",
    "Certificate": "certificate.certificate",
    "Embedding": "marking.embedding_result",
    "Extraction": "ownership.extraction_result",
    "FormatError": "errors",
    "InputError": "errors",
    "Key": "coding.keys",
    "KeyFileError": "errors",
    "Mesh": "mesh",
    "MeshmarkError": "errors",
    "OutputError": "errors",
    "Recovery": "authentication.part_recovery",
    "Unmarked": "marking.undo",
    "analyse": "saliency",
    "authenticate": "authentication.verdict",
    "compare": "metrics",
    "embed": "marking.both_layers",
    "embed_file": "marking.marked_file",
    "extract": "marking.both_layers_extraction",
    "read_mesh": "io",
    "recover": "marking.original_recovery",
    "segment": "segmentation",
    "unmark": "marking.undo",
    "write_mesh": "io",
}


# Before anything imports NumPy.
same_on_every_processor()
__getattr__ = late_names(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__"})

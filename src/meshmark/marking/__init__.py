"""NCDG-LV: the paper's chain as one scheme, with its layers of ownership and of authentication."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.late import late_names

if TYPE_CHECKING:
    from meshmark.authentication.part_recovery import Recovery
    from meshmark.authentication.verdict import Authentication, authenticate
    from meshmark.certificate.certificate import Certificate
    from meshmark.marking.both_layers import embed
    from meshmark.marking.both_layers_extraction import extract
    from meshmark.marking.embedding_result import AuthenticationMark, Embedding
    from meshmark.marking.marked_file import embed_file
    from meshmark.marking.original_recovery import recover
    from meshmark.marking.undo import Unmarked, unmark
    from meshmark.ownership.extraction_result import Evidence, Extraction
    from meshmark.ownership.ownership_mark import OwnershipMark

__all__ = [
    "Authentication",
    "AuthenticationMark",
    "Certificate",
    "Embedding",
    "Evidence",
    "Extraction",
    "OwnershipMark",
    "Recovery",
    "Unmarked",
    "authenticate",
    "embed",
    "embed_file",
    "extract",
    "recover",
    "unmark",
]

_HOME = {
    "Authentication": "authentication.verdict",
    "AuthenticationMark": "marking.embedding_result",
    "Certificate": "certificate.certificate",
    "Embedding": "marking.embedding_result",
    "Evidence": "ownership.extraction_result",
    "Extraction": "ownership.extraction_result",
    "OwnershipMark": "ownership.ownership_mark",
    "Recovery": "authentication.part_recovery",
    "Unmarked": "marking.undo",
    "authenticate": "authentication.verdict",
    "embed": "marking.both_layers",
    "embed_file": "marking.marked_file",
    "extract": "marking.both_layers_extraction",
    "recover": "marking.original_recovery",
    "unmark": "marking.undo",
}

__getattr__ = late_names(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)

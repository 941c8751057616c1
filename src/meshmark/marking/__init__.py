"""NCDG-LV: the paper's chain as one scheme, with its layers of ownership and of authentication."""

from __future__ import annotations

from meshmark.authentication.part_recovery import Recovery, recover
from meshmark.authentication.verdict import Authentication, authenticate
from meshmark.certificate.certificate import Certificate
from meshmark.marking.both_layers import embed
from meshmark.marking.embedding_result import AuthenticationMark, Embedding
from meshmark.marking.marked_file import embed_file
from meshmark.marking.undo import Unmarked, unmark
from meshmark.ownership.extraction import extract
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

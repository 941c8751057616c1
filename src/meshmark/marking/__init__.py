"""NCDG-LV: the paper's chain as one scheme, with its layers of ownership and of authentication."""

from __future__ import annotations

from meshmark.authentication.part_recovery import Recovery, recover
from meshmark.authentication.verdict import Authentication, authenticate
from meshmark.certificate.certificate import Certificate
from meshmark.marking.layers import embed
from meshmark.marking.undo import Unmarked, unmark
from meshmark.ownership.extraction import extract
from meshmark.ownership.results import Embedding, Extraction

__all__ = [
    "Authentication",
    "Certificate",
    "Embedding",
    "Extraction",
    "Recovery",
    "Unmarked",
    "authenticate",
    "embed",
    "extract",
    "recover",
    "unmark",
]

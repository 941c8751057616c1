"""NCDG-LV: the paper's chain as one scheme, with its layers of ownership and of authentication."""

from __future__ import annotations

from meshmark.schemes.ncdg_lv.authentication.recovering import Recovery, recover
from meshmark.schemes.ncdg_lv.authentication.verdict import Authentication, authenticate
from meshmark.schemes.ncdg_lv.certificate import Certificate
from meshmark.schemes.ncdg_lv.extraction import extract
from meshmark.schemes.ncdg_lv.layers import embed
from meshmark.schemes.ncdg_lv.results import Embedding, Extraction
from meshmark.schemes.ncdg_lv.undo import Unmarked, unmark

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

"""NCDG-LV: the paper's chain as one scheme; here its ownership layer."""

from __future__ import annotations

from meshmark.schemes.ncdg_lv.certificate import Certificate
from meshmark.schemes.ncdg_lv.embedding import embed
from meshmark.schemes.ncdg_lv.extraction import extract
from meshmark.schemes.ncdg_lv.results import Embedding, Extraction

__all__ = ["Certificate", "Embedding", "Extraction", "embed", "extract"]

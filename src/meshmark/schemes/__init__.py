"""Watermarking schemes: one interface, and the table of them."""

from __future__ import annotations

from meshmark.schemes.scheme import Readout, Scheme
from meshmark.schemes.table import SCHEMES

__all__ = ["SCHEMES", "Readout", "Scheme"]

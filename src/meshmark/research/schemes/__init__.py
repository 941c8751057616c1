"""Watermarking schemes: one interface, and the table of them, which is imported when it is first used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from meshmark.research.schemes.scheme import Readout, Scheme

if TYPE_CHECKING:
    from meshmark.research.schemes.table import SCHEMES

__all__ = ["SCHEMES", "Readout", "Scheme"]


def __getattr__(name: str) -> Any:
    if name != "SCHEMES":
        raise AttributeError(f"module 'meshmark.research.schemes' has no attribute {name!r}")
    from meshmark.research.schemes.table import SCHEMES

    return SCHEMES

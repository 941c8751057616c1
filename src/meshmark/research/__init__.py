"""Research: schemes and rivals, ablation, training and the benchmark; the product never imports it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from meshmark.research.schemes.table import SCHEMES

__all__ = ["SCHEMES"]


def __getattr__(name: str) -> Any:
    if name != "SCHEMES":
        raise AttributeError(f"module 'meshmark.research' has no attribute {name!r}")
    from meshmark.research.schemes.table import SCHEMES

    return SCHEMES

"""How long an answer took, as strangers may know it: to the next of a few round numbers."""

from __future__ import annotations

from typing import Final

__all__ = ["SECONDS", "rounded_up"]

SECONDS: Final = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)


def rounded_up(seconds: float) -> float:
    """Return the first of `SECONDS` that is not below a time, the last where all are."""
    return next((limit for limit in SECONDS if seconds <= limit), SECONDS[-1])

"""Words that several readers use in their remarks."""

from __future__ import annotations

__all__ = ["amount", "surplus"]


def amount(count: int, one: str, many: str) -> str:
    """Return "1 byte" or "2 bytes"."""
    return f"{count:,} {one if count == 1 else many}"


def surplus(count: int, one: str, many: str) -> str:
    """Return the remark about what lies behind the data that a header declares."""
    verb, be = ("follows", "is") if count == 1 else ("follow", "are")
    return f"{amount(count, one, many)} {verb} the data that the header declares, and {be} kept"

"""The payload: a 64-bit id, written as 16 hexadecimal digits."""

from __future__ import annotations

import re
import secrets

from meshmark.errors import InputError

__all__ = ["ID_BITS", "check_id", "format_id", "parse_id", "random_id"]

ID_BITS = 64
_HEX = re.compile(r"[0-9a-fA-F]{16}")


def parse_id(text: str) -> int:
    """Return the id written as 16 hexadecimal digits; raises `InputError` for anything else."""
    if not _HEX.fullmatch(text):
        raise InputError(f"the id {text!r} is not valid, expected 16 hexadecimal digits")
    return int(text, 16)


def format_id(identity: int) -> str:
    """Return the 16 lower-case hexadecimal digits of an id; raises `InputError` outside 0 to 2^64 - 1."""
    return f"{check_id(identity):016x}"


def random_id() -> int:
    """Draw an id from the operating system's random source."""
    return secrets.randbits(ID_BITS)


def check_id(identity: int) -> int:
    """Return the id unchanged; raises `InputError` outside 0 to 2^64 - 1."""
    if not 0 <= identity < 1 << ID_BITS:
        raise InputError(f"the id {identity} is not a {ID_BITS}-bit number")
    return identity

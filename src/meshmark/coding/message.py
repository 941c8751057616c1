"""The payload: an id of 64 bits, or, where a model is too small for it, one of 32 bits, or none.

Ids are whole numbers throughout the program, and a number says how many bits it is of: an id of 64 bits is
itself, below 2^64; one of 32 bits is `SHORT_IDS` more than what its 8 hexadecimal digits say; `PRESENCE` stands
for the mark that carries no id. So the ids 1 of 64 bits and 1 of 32 bits are never taken for each other.
"""

from __future__ import annotations

import re
import secrets
from typing import Final

from meshmark.errors import InputError

__all__ = [
    "BITS",
    "ID_BITS",
    "PRESENCE",
    "SHORT_BITS",
    "bits_of",
    "format_id",
    "parse_id",
    "random_id",
    "requested_id",
    "short_id",
    "told_id",
]

ID_BITS: Final = 64
SHORT_BITS: Final = 32
BITS: Final = (ID_BITS, SHORT_BITS, 0)
"""How many bits a mark may carry; 0: it says that it is there."""
SHORT_IDS: Final = 1 << 96
PRESENCE: Final = 1 << 97
_HEX = re.compile(r"[0-9a-fA-F]{8}(?:[0-9a-fA-F]{8})?")


def parse_id(text: str, bits: int | None = None) -> int:
    """Return the id of 16 hexadecimal digits, or, of 32 bits, of 8.

    bits: how many it has to have, 64, 32, or 0, of which there is none; None: 64 or 32. Raises `InputError` for
    anything else.
    """
    if not _HEX.fullmatch(text):
        raise InputError(
            f"the id {text!r} is not valid, expected 16 hexadecimal digits, or 8 of an id of 32 bits"
        )
    own = 4 * len(text)
    if bits is not None and own != bits:
        expected = f"{bits // 4} hexadecimal digits" if bits else "none with 0 bits"
        raise InputError(f"the id {text!r} is one of {own} bits, expected {expected}")
    return int(text, 16) if own == ID_BITS else short_id(int(text, 16))


def format_id(identity: int) -> str:
    """Return the 16 lower-case hexadecimal digits of an id, or the 8 of one of 32 bits.

    Raises `InputError` for any other number.
    """
    bits = bits_of(identity)
    if not bits:
        raise InputError(f"the number {identity} stands for a mark without an id, expected an id")
    return f"{identity % (1 << bits):0{bits // 4}x}"


def random_id(bits: int = ID_BITS) -> int:
    """Draw an id of 64 or 32 bits from the operating system's random source."""
    return secrets.randbits(ID_BITS) if bits == ID_BITS else short_id(secrets.randbits(SHORT_BITS))


def short_id(serial: int) -> int:
    """Return the id of 32 bits with a serial number; raises `InputError` outside 0 to 2^32 - 1."""
    if not 0 <= serial < 1 << SHORT_BITS:
        raise InputError(f"the id {serial} is not a {SHORT_BITS}-bit number")
    return SHORT_IDS + serial


def bits_of(identity: int) -> int:
    """Return of how many bits an id is: 64 or 32, 0 for `PRESENCE`; raises `InputError` for other numbers."""
    if 0 <= identity < 1 << ID_BITS:
        return ID_BITS
    if SHORT_IDS <= identity < SHORT_IDS + (1 << SHORT_BITS):
        return SHORT_BITS
    if identity == PRESENCE:
        return 0
    raise InputError(f"the id {identity} is not a {ID_BITS}-bit number")


def told_id(identity: int | None) -> int | None:
    """Return an id as callers are told it: None where there is none, of `PRESENCE` too."""
    return None if identity == PRESENCE else identity


def requested_id(id: int | None, bits: int) -> int:
    """Return the number of the id to embed: as asked for, of so many bits, or drawn at random.

    Parameters
    ----------
    id : int or None
        With 32 bits either the serial number below 2^32 or what `short_id` makes of it. None: drawn at random.
    bits : int
        One of `BITS`; with 0 there is no id.

    Raises
    ------
    InputError
        The number of bits is unknown, or the id is of another number of bits.
    """
    if bits not in BITS:
        raise InputError(f"an id of {bits} bits is not known, expected one of {', '.join(map(str, BITS))}")
    if not bits:
        if id not in (None, PRESENCE):
            raise InputError("a mark of 0 bits carries no id, expected none")
        return PRESENCE
    if id is None:
        return random_id(bits)
    if bits == SHORT_BITS and id < SHORT_IDS:
        return short_id(id)
    found = bits_of(id)
    if found != bits:
        raise InputError(
            f"the id is one of {found} bits, expected {bits // 4} hexadecimal digits, or bits={found} for it"
            if found
            else f"a mark of {bits} bits carries an id, expected one"
        )
    return id

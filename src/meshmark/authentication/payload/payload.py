"""The payload of the mark vertices: what it is, how much fits, and its symbols (docs/design.md, section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.payload.signed_totals import SIZE, Whole
from meshmark.coding.erasure import erasure_code as erasure
from meshmark.errors import CapacityError, InputError

__all__ = [
    "HEAD",
    "INTACT",
    "KINDS",
    "Payload",
    "SymbolSource",
    "capacity",
    "decode",
    "encoder",
    "pack",
    "unpack",
]

SymbolSource = Callable[[NDArray[np.uint32]], NDArray[np.uint16]]

KINDS = ("none", "miniature", "bytes", "image")
"""What a payload can be; the place in this list is its first byte."""
HEAD = 1 + SIZE
"""Bytes before the content: its kind, and what was signed off as a whole; more where it shows copies or more."""
# Set in the first byte of a model that shows copies, of one whose file showed something else than its surface, and
# of one whose marks that tell the id have rings of which no two are alike.
_COPIES, _SHOWN, _ONCE = 0x80, 0x40, 0x20
INTACT = 0.55
"""Share of the marks that must be left for the payload: 60 % of a surface, less what its border breaks."""


@dataclass(frozen=True, kw_only=True)
class Payload:
    """kind: one of `KINDS`; content: a miniature's bytes, the user's bytes, or those of an image file as it was.

    whole: what was signed off.
    """

    kind: str
    content: bytes
    whole: Whole = field(default_factory=Whole)


def pack(kind: str, content: bytes = b"", whole: Whole | None = None) -> bytes:
    """Return the bytes to encode; raises `InputError` for an unknown kind, or for content of the kind "none"."""
    if kind not in KINDS:
        raise InputError(f"unknown payload '{kind}', expected one of {', '.join(KINDS)}")
    if kind == "none" and content:
        raise InputError(f"the payload 'none' has {len(content)} bytes of content, expected no content")
    whole = whole or Whole()
    flags = (_COPIES if whole.distinct else 0) | (_SHOWN if whole.shown else 0) | (_ONCE if whole.once else 0)
    return bytes([KINDS.index(kind) | flags]) + whole.packed() + content


def unpack(packed: bytes) -> Payload:
    """Undo `pack`; raises `InputError` where the first byte names no kind."""
    kind = packed[0] & ~(_COPIES | _SHOWN | _ONCE) if packed else len(KINDS)
    if len(packed) < HEAD or kind >= len(KINDS):
        raise InputError(
            "the payload is of a kind that this version does not know, expected a newer meshmark"
        )
    copies, shown, once = (bool(packed[0] & flag) for flag in (_COPIES, _SHOWN, _ONCE))
    whole, content = Whole.read(packed[1:], copies=copies, shown=shown, once=once)
    return Payload(kind=KINDS[kind], content=content, whole=whole)


def capacity(marks: int, symbol_bits: int, intact: float = INTACT) -> int:
    """Return the bytes of content that are read back when a share `intact` (0 to 1) of the marks is left."""
    if not 0.0 < intact <= 1.0:
        raise InputError(f"a share of {intact:g} of the marks is out of range, expected above 0 to 1")
    return max(erasure.capacity(int(marks * intact), symbol_bits) - HEAD, 0)


def encoder(packed: bytes, symbol_bits: int, marks: int) -> SymbolSource:
    """Return the symbols of packed content by index.

    Raises `CapacityError` where it does not fit even if every mark stays.
    """
    most = capacity(marks, symbol_bits, 1.0)
    if len(packed) > most + HEAD:
        raise CapacityError(
            f"the payload has {len(packed) - HEAD} bytes, expected at most {most} for {marks} mark vertices"
        )
    return erasure.ErasureCode(packed, symbol_bits)


def decode(index: NDArray[np.uint32], value: NDArray[np.uint16], symbol_bits: int) -> bytes | None:
    """Return the packed content from symbols (k,) and their indices (k,) in any order, or None."""
    return erasure.decode(index, value, symbol_bits)

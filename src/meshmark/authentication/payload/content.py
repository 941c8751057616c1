"""What a payload holds: a miniature of the model, the user's bytes, or an image file as it is."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from meshmark.authentication.payload.payload import INTACT, capacity, pack
from meshmark.authentication.payload.signed_totals import Whole
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.surface import Surface
from meshmark.recovery.miniature import miniature

__all__ = ["Asked", "Content", "content_for", "content_of"]

Content = str | bytes | os.PathLike[str] | None
"""What callers may ask for: "miniature", "none", bytes, the path of a file, or None for what suits the model."""
LONGEST = 50_000_000
# How image files begin.
_IMAGES = (
    b"\x89PNG\r\n\x1a\n",
    b"\xff\xd8\xff",
    b"GIF8",
    b"BM",
    b"II*\0",
    b"MM\0*",
    b"P4",
    b"P5",
    b"P6",
    b"\0\0\x01\0",
)


@dataclass(frozen=True)
class Asked:
    """kind: of `payload.KINDS`, or "any" for a miniature where it fits; content: bytes or those of a file."""

    kind: str
    content: bytes = b""


def content_of(payload: Content) -> Asked:
    """Return what is asked for; raises `InputError` where a file cannot be read or is far too long."""
    if payload is None:
        return Asked("any")
    if payload in ("miniature", "none"):
        return Asked(str(payload))
    content = payload if isinstance(payload, bytes) else _read(Path(payload))
    is_image = content.startswith(_IMAGES) or (content[:4] == b"RIFF" and content[8:12] == b"WEBP")
    return Asked("image" if is_image else "bytes", content)


def content_for(
    asked: Asked, surface: Surface, whole: Whole, marks: tuple[int, int], *, made: bytes | None = None
) -> tuple[bytes, tuple[str, ...]]:
    """Return the packed payload for marks, and remarks about it.

    surface: of a miniature; whole: what is signed off; marks: how many have different symbols, and the bits of
    each; made: a miniature of this surface, which is taken where it fits. Raises `CapacityError` where what was
    asked for does not fit; where it is a miniature that nobody asked for, a remark says that it is left out.
    """
    symbols, symbol_bits = marks
    room = max(capacity(symbols, symbol_bits) - whole.more, 0)
    if asked.kind in ("any", "miniature") and made and len(made) <= room:
        return pack("miniature", made, whole), ()
    if asked.kind == "any":
        try:
            return pack("miniature", _miniature(surface, room), whole), ()
        except CapacityError as error:
            return pack("none", whole=whole), (f"{error}: no payload, so altered parts cannot be recovered",)
    if asked.kind == "miniature":
        return pack("miniature", _miniature(surface, room), whole), ()
    if asked.kind == "none":
        return pack("none", whole=whole), ()
    size = len(asked.content)
    most = max(capacity(symbols, symbol_bits, 1.0) - whole.more, 0)
    if size > most:
        raise CapacityError(f"the payload has {size:,} bytes, expected at most {most:,} in this model")
    if size > room:
        share = 0.01 * next(
            percent
            for percent in range(int(100 * INTACT), 101)
            if _fits(size + whole.more, symbols, symbol_bits, percent)
        )
        remark = (
            f"the payload fills the model: it is read back only while {share:.0%} of the marks are intact"
        )
        return pack(asked.kind, asked.content, whole), (remark,)
    return pack(asked.kind, asked.content, whole), ()


def _miniature(surface: Surface, room: int) -> bytes:
    return miniature(surface.points, surface.faces, room, frame=surface.frame)


def _fits(size: int, symbols: int, symbol_bits: int, percent: int) -> bool:
    return size <= capacity(symbols, symbol_bits, percent / 100.0)


def _read(path: Path) -> bytes:
    try:
        if path.stat().st_size > LONGEST:
            raise InputError(
                f"{path} is longer than {LONGEST:,} bytes, expected a payload that a model can hold"
            )
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the payload {path}: {error.strerror or 'error'}") from None

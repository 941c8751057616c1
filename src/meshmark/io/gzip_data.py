"""Gzipped files: packed so that equal data gives equal bytes, and unpacked up to a bound."""

from __future__ import annotations

import io
import zlib
from gzip import GzipFile

from meshmark.errors import FormatError

__all__ = ["GZIP_MAGIC", "MOST_BYTES", "gzipped", "unpacked"]

GZIP_MAGIC = b"\x1f\x8b"

# Files beyond this are refused: their arrays would not fit into an ordinary machine's memory.
MOST_BYTES = 4 << 30
# Text of numbers shrinks up to twentyfold; a small file that grows beyond both limits is a trap.
_MAX_GROWTH = 200
_ALWAYS_ALLOWED = 64 << 20
# For zlib: 32 kB of window, and a gzip header.
_GZIP_WINDOW = 16 + zlib.MAX_WBITS


def gzipped(data: bytes) -> bytes:
    """Return `data` gzipped, without name or time: equal data gives equal bytes."""
    out = io.BytesIO()
    with GzipFile(filename="", mode="wb", fileobj=out, mtime=0, compresslevel=6) as packer:
        packer.write(data)
    return out.getvalue()


def unpacked(raw: bytes) -> tuple[bytes, bytes]:
    """Return what is in a gzipped file, and the bytes behind it that are not gzip data."""
    limit = min(max(_ALWAYS_ALLOWED, _MAX_GROWTH * len(raw)), MOST_BYTES)
    pieces, left, size = list[bytes](), raw, 0
    while left.startswith(GZIP_MAGIC):
        member = zlib.decompressobj(_GZIP_WINDOW)
        try:
            pieces.append(member.decompress(left, limit - size + 1))
        except zlib.error as error:
            raise FormatError(f"the gzip data is damaged ({error})") from None
        size += len(pieces[-1])
        if size > limit:
            raise FormatError(
                f"the gzip data unpacks to more than {limit >> 20} MB, which no model of its size does"
            )
        if not member.eof:
            raise FormatError("the gzip data is damaged (it ends before its end mark)")
        left = member.unused_data
    if not size:
        raise FormatError("the gzip data is empty, expected a model file")
    return b"".join(pieces), left

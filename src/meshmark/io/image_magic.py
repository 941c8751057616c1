"""Whether bytes begin as an image of a format that models refer to."""

from __future__ import annotations

import struct
from typing import Final

__all__ = ["HEAD", "is_image"]

HEAD: Final = 32
"""Bytes of a file that tell."""
_BEGINNINGS: Final = (
    b"\x89PNG\r\n\x1a\n",
    b"\xff\xd8\xff",
    b"GIF87a",
    b"GIF89a",
    b"II*\0",
    b"MM\0*",
    b"\xabKTX 11\xbb\r\n\x1a\n",
    b"\xabKTX 20\xbb\r\n\x1a\n",
    b"DDS |\0\0\0",
    b"8BPS\0\1",
    b"#?RADIANCE",
    b"\x76\x2f\x31\x01",
    b"\0\0\1\0",
    b"\0\0\0\x0cjP  \r\n\x87\n",
)
_TGA_TYPES, _TGA_DEPTHS = (1, 2, 3, 9, 10, 11), (8, 15, 16, 24, 32)


def is_image(head: bytes) -> bool:
    """Return whether the first bytes of a file, `HEAD` of them or the whole file, are those of an image.

    PNG, JPEG, GIF, TIFF, KTX, KTX2, DDS, PSD, HDR, OpenEXR, ICO, JPEG 2000, BMP, PNM, WebP, AVIF, HEIF and TGA.
    """
    if head.startswith(_BEGINNINGS):
        return True
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return True
    if head[4:8] == b"ftyp" and head[8:12] in (b"avif", b"avis", b"heic", b"heix", b"mif1"):
        return True
    if head[:1] == b"P" and head[1:2] in b"123456" and head[2:3].isspace():
        return True
    return _is_bmp(head) or _is_tga(head)


def _is_bmp(head: bytes) -> bool:
    return head[:2] == b"BM" and len(head) >= 26 and head[6:10] == bytes(4)


def _is_tga(head: bytes) -> bool:
    """Return whether a header without a magic number is one of a Truevision image."""
    if len(head) < 18:
        return False
    mapped, kind, width, height, depth = (head[1], head[2], *struct.unpack_from("<HHB", head, 12))
    return mapped in (0, 1) and kind in _TGA_TYPES and depth in _TGA_DEPTHS and width > 0 and height > 0

"""STL, binary or as text; a binary one may also start with the word `solid`."""

from __future__ import annotations

from pathlib import Path

from meshmark.io.patch_document import PatchDocument
from meshmark.io.stl_binary import FACET, HEAD, parse_binary_stl
from meshmark.io.stl_text import parse_text_stl

__all__ = ["parse_stl"]


def parse_stl(data: bytes, _path: Path) -> PatchDocument:
    """Read an STL file. Raises `FormatError` where it breaks the format."""
    facets = int.from_bytes(data[80:HEAD], "little")
    binary = len(data) >= HEAD and len(data) == HEAD + FACET.itemsize * facets
    # The text is looked for behind a byte order mark too; zero bytes never occur in it.
    text = data.lstrip(b"\xef\xbb\xbf \t\r\n")[:5].lower() == b"solid" and b"\0" not in data[:1024]
    utf16 = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    return parse_text_stl(data) if (text or utf16) and not binary else parse_binary_stl(data)

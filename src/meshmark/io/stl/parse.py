"""STL, binary or as text; a binary one may also start with the word `solid`, and a text with comments."""

from __future__ import annotations

import re
from pathlib import Path

from meshmark.errors import FormatError
from meshmark.io.patch_document import PatchDocument
from meshmark.io.stl.binary import FACET, HEAD, parse_binary_stl
from meshmark.io.stl.text import parse_text_stl

__all__ = ["parse_stl"]

_HEAD = 65536
# Before the first solid there may be comments, and a byte order mark.
_SOLID = re.compile(rb"(?:^|[\r\n])(?:\xef\xbb\xbf)?\s*solid\b", re.IGNORECASE)
_NO_TEXT = re.compile(rb"[^\t\n\x0b\x0c\r -~\x80-\xff]")


def parse_stl(data: bytes, _path: Path) -> PatchDocument:
    """Read an STL file. Raises `FormatError` where it breaks the format."""
    facets = int.from_bytes(data[80:HEAD], "little")
    binary = len(data) >= HEAD and len(data) == HEAD + FACET.itemsize * facets
    head = data[:_HEAD]
    # Zero bytes never occur in a text.
    text = _SOLID.search(head) is not None and b"\0" not in data[:1024]
    utf16 = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    if (text or utf16) and not binary:
        return parse_text_stl(data)
    if data and not binary and _NO_TEXT.search(head) is None:
        raise FormatError("the file is text without a line 'solid', expected an STL file")
    return parse_binary_stl(data)

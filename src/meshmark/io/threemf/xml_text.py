"""XML read with the standard library's expat, safely: no document types, so no entities to expand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from xml.parsers import expat

from meshmark.errors import FormatError

__all__ = ["as_utf8", "walk_xml"]

# How the parser joins namespace and name; no namespace address holds a blank.
_JOINT = " "
# The first two bytes of UTF-16: a byte order mark, or "<" at once.
_WIDE = {b"\xff\xfe": "utf-16-le", b"<\0": "utf-16-le", b"\xfe\xff": "utf-16-be", b"\0<": "utf-16-be"}

Start = Callable[[str, Mapping[str, str], int], None]


def as_utf8(text: bytes, name: str) -> tuple[bytes, str]:
    """Return XML in UTF-8, and the encoding that it had: "utf-8", "utf-16-le" or "utf-16-be".

    Encoded again, the result is the text to the last byte. Raises `FormatError` where it is in neither.
    """
    encoding = _WIDE.get(text[:2], "utf-8")
    if encoding == "utf-8" and b"\0" in text[:4]:
        raise FormatError(f"{name} is not XML in UTF-8 or UTF-16")
    try:
        return (text if encoding == "utf-8" else text.decode(encoding).encode()), encoding
    except UnicodeDecodeError as error:
        raise FormatError(f"{name} is not well-formed UTF-16 at byte {error.start}") from None


def walk_xml(
    text: bytes, name: str, start: Start, end: Callable[[str], None], line: Callable[[int], int] | None = None
) -> None:
    """Call start(tag, attributes, byte offset of its "<") and end(tag) for each element of XML in UTF-8.

    Tags and attributes are "namespace name", or "name" without a namespace. name: for messages.
    line: the line of a byte offset, for messages, where the text is not the whole of the file.
    Raises `FormatError` for XML that is not well formed, not UTF-8, or has a document type.
    """
    parser = expat.ParserCreate("UTF-8", namespace_separator=_JOINT)

    def refuse(*_: object) -> None:
        raise FormatError(f"{name} declares a document type, which 3MF forbids")

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda tag, attributes: start(tag, attributes, parser.CurrentByteIndex)
    parser.EndElementHandler = end
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        problem, where = expat.ErrorString(error.code), error.lineno
        if line is not None:
            where = line(parser.ErrorByteIndex)
        raise FormatError(f"{name} is broken XML at line {where}: {problem}") from None

"""XML read with the standard library's expat, safely: no document types, so no entities to expand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from xml.parsers import expat

from meshmark.errors import FormatError

__all__ = ["walk_xml"]

# How the parser joins namespace and name; no namespace address holds a blank.
_JOINT = " "

Start = Callable[[str, Mapping[str, str], int], None]


def walk_xml(text: bytes, name: str, start: Start, end: Callable[[str], None]) -> None:
    """Call start(tag, attributes, byte offset of its "<") and end(tag) for each element.

    Tags and attributes are "namespace name", or "name" without a namespace. name: for messages.
    Raises `FormatError` for XML that is not well formed, not UTF-8, or has a document type.
    """
    if text[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in text[:4]:
        raise FormatError(f"{name} is not UTF-8 text, expected XML in UTF-8")
    parser = expat.ParserCreate("UTF-8", namespace_separator=_JOINT)

    def refuse(*_: object) -> None:
        raise FormatError(f"{name} declares a document type, which 3MF forbids")

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda tag, attributes: start(tag, attributes, parser.CurrentByteIndex)
    parser.EndElementHandler = end
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        problem = expat.ErrorString(error.code)
        raise FormatError(f"{name} is broken XML at line {error.lineno}: {problem}") from None

"""The long lists in a 3MF model, `<vertices>` and `<triangles>`: their numbers, and where these stand.

Lists written plainly are read with numpy, a hundred times faster than element by element. Plainly means:
no attributes on the list itself, x y z (v1 v2 v3) first and in this order. Everything else is left to the
XML parser, which also checks what is around the lists; both ways give the same (a test compares them).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.text.numbers import ByteArray, compact
from meshmark.mesh import FloatArray, IntArray

__all__ = ["PlainList", "attribute_spans", "number", "plain_lists", "whole_number"]

_NUMBER = rb"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
# Further attributes: printable ASCII, and no namespace declarations, which could rename the element.
_MORE = rb'(?:\s+(?!xmlns)[A-Za-z_][\w:.-]*\s*=\s*"[ !#-%\'-;=-~]*+")*+'


def _list_pattern(item: bytes, value: bytes, names: tuple[bytes, ...]) -> re.Pattern[bytes]:
    triple = b"".join(rb"\s+%s\s*=\s*\"%s\"" % (name, value) for name in names)
    return re.compile(rb"(?:\s*<%s%s%s\s*(?:/>|>\s*</%s\s*>))*+\s*" % (item, triple, _MORE, item))


_LISTS = {
    b"vertices": _list_pattern(b"vertex", _NUMBER, (b"x", b"y", b"z")),
    b"triangles": _list_pattern(b"triangle", rb"[0-9]+", (b"v1", b"v2", b"v3")),
}
_OPEN = re.compile(rb"<(vertices|triangles)\s*>")
_ATTRIBUTE = re.compile(rb"\s*([^\s=<>/\"']+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
_TAG_NAME = re.compile(rb"<[^\s/>]+")
_QUOTE, _LESS, _SLASH = 34, 60, 47
_SIMPLE = re.compile(r"\s*" + _NUMBER.decode() + r"\s*")


@dataclass(frozen=True, eq=False, kw_only=True)
class PlainList:
    """Rows of three numbers: starts and ends, (k, 3), are their spans in the part's text."""

    starts: IntArray
    ends: IntArray
    values: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


def plain_lists(text: bytes) -> tuple[bytes, dict[int, PlainList], list[tuple[int, int]]]:
    """Cut the plainly written lists out of a model part.

    Return the text that is left, the lists by the offset that their opening tag has in it, and where and how many
    bytes were cut out of it.
    """
    # A comment, CDATA section, document type or processing instruction could hold what only looks like a
    # list.
    if b"<!" in text or text.count(b"<?") > text.startswith((b"<?", b"\xef\xbb\xbf<?")):
        return text, {}, []
    letters = np.frombuffer(text, np.uint8)
    pieces, lists, cuts, at, kept = [], dict[int, PlainList](), list[tuple[int, int]](), 0, 0
    for tag in _OPEN.finditer(text):
        body = _LISTS[tag.group(1)].match(text, tag.end())
        end = body.end() if body else tag.end()
        if not text.startswith(b"</" + tag.group(1), end):
            continue
        lists[kept + tag.start() - at] = _parsed(letters, tag.end(), end)
        kept += tag.end() - at
        pieces.append(text[at : tag.end()])
        cuts.append((kept, end - tag.end()))
        at = end
    return b"".join([*pieces, text[at:]]), lists, cuts


def _parsed(letters: ByteArray, start: int, end: int) -> PlainList:
    body = letters[start:end]
    tags = np.flatnonzero(body == _LESS)
    tags = tags[body[tags + 1] != _SLASH]
    quotes = np.flatnonzero(body == _QUOTE)
    # The first six quotes after each "<" enclose the three numbers.
    marks = (
        quotes[np.searchsorted(quotes, tags)[:, None] + np.arange(6)] if len(tags) else np.empty((0, 6), int)
    )
    starts, ends = marks[:, ::2] + 1, marks[:, 1::2]
    packed = compact(body, starts.ravel(), ends.ravel()).tobytes()
    values = np.fromstring(packed, np.float64, sep=" ") if packed else np.empty(0)
    return PlainList(starts=starts + start, ends=ends + start, values=values.reshape(-1, 3))


def attribute_spans(text: bytes, tag: int, names: tuple[bytes, ...]) -> list[tuple[int, int]]:
    """Return the spans of the values of these attributes of the element whose "<" stands at `tag`."""
    opening = _TAG_NAME.match(text, tag)
    at, found = opening.end() if opening else tag, {}
    while item := _ATTRIBUTE.match(text, at):
        found[item.group(1)] = item.span(2) if item.group(2) is not None else item.span(3)
        at = item.end()
    return [found[name] for name in names]


def number(attributes: Mapping[str, str], name: str, where: str) -> float:
    """Return a finite decimal number. Raises `FormatError`."""
    word = attributes.get(name, "")
    value = float(word) if _SIMPLE.fullmatch(word) else np.inf
    if not np.isfinite(value):
        raise FormatError(f"{where}: {name} is {word[:40]!r}, expected a finite number")
    return value


def whole_number(attributes: Mapping[str, str], name: str, where: str) -> float:
    """Return an index. Raises `FormatError`."""
    word = attributes.get(name, "").strip()
    if not (word.isascii() and word.isdigit() and len(word) < 16):
        raise FormatError(f"{where}: {name} is {word[:40]!r}, expected an index")
    return float(word)

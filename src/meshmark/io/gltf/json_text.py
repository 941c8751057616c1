"""Where values stand in a JSON text, so that one number can be replaced and no other byte changes."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable
from typing import Any

from meshmark.errors import FormatError

__all__ = ["Span", "load_json", "locate", "replace"]

Span = tuple[int, int]
Path = tuple[str | int, ...]

_TOKEN = re.compile(rb'"[^"\\]*(?:\\.[^"\\]*)*"|[{}\[\],:]|[^\s{}\[\],:"]+', re.DOTALL)


def _no_constant(word: str) -> Any:
    raise FormatError(f"the JSON text holds {word}, expected finite numbers")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise FormatError(f"the JSON text gives the name {twice!r} twice in one object, expected once")
    return table


def load_json(text: bytes) -> Any:
    """Parse strict JSON in UTF-8 (a byte order mark is passed over).

    Raises `FormatError` for anything else: other encodings, NaN, repeated names, nesting too deep.
    """
    try:
        return json.loads(text.decode("utf-8-sig"), parse_constant=_no_constant, object_pairs_hook=_unique)
    except UnicodeDecodeError as error:
        raise FormatError(f"the JSON text is not UTF-8 at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise FormatError(f"the JSON text is broken at line {error.lineno}: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError("the JSON text is nested too deeply or holds a number too long") from None


def locate(text: bytes, wanted: Collection[Path]) -> dict[Path, Span]:
    """Return the spans (start, end) of the string, number and literal values at the wanted paths.

    A path is names and indices from the root, as ("accessors", 3, "min", 0). The text must be valid JSON.
    """
    found: dict[Path, Span] = {}
    keys: set[Path] = set(wanted)
    path: list[str | int] = []
    is_name = False
    for token in _TOKEN.finditer(text):
        first = text[token.start()]
        if first in b"{[":
            is_name = first == 0x7B
            path.append("" if is_name else 0)
        elif first in b"}]":
            path.pop()
            is_name = False
        elif first == 0x2C:
            step = path[-1]
            is_name = isinstance(step, str)
            if isinstance(step, int):
                path[-1] = step + 1
        elif first == 0x3A:
            is_name = False
        elif is_name:
            path[-1] = json.loads(token.group())
        elif tuple(path) in keys:
            found[tuple(path)] = token.span()
    return found


def replace(text: bytes, edits: Iterable[tuple[Span, bytes]]) -> bytes:
    """Return the text with each span, none overlapping, replaced by the bytes given for it."""
    pieces, end = [], 0
    for (start, stop), new in sorted(edits):
        pieces += [text[end:start], new]
        end = stop
    return b"".join([*pieces, text[end:]])

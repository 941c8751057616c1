"""The header of a PLY file: its encoding, its elements and their properties."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from meshmark.errors import FormatError

__all__ = ["Element", "PlyHeader", "Property", "parse_header"]

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

_LINE = re.compile(rb"([^\r\n]*)(\r\n|\n|\r)")
# A header is text of a few lines; without a limit a damaged file would be searched to its end.
_MAX_LINES = 10_000


@dataclass(frozen=True, kw_only=True)
class Property:
    """A property: `dtype` of its values, and of the count before them if it is a list."""

    name: str
    dtype: np.dtype[np.generic]
    count: np.dtype[np.generic] | None = None


@dataclass(frozen=True, kw_only=True)
class Element:
    """An element: `rows` of the same properties."""

    name: str
    rows: int
    properties: tuple[Property, ...]

    def find(self, *names: str) -> Property | None:
        """Return the first property with one of these names, or None."""
        return next((entry for entry in self.properties if entry.name in names), None)


@dataclass(frozen=True, kw_only=True)
class PlyHeader:
    """A PLY header. order: byte order, "<" or ">"; "" for text. size: bytes up to the data."""

    order: str
    elements: tuple[Element, ...]
    size: int

    def element(self, name: str) -> Element | None:
        """Return the element of this name, or None."""
        return next((entry for entry in self.elements if entry.name == name), None)


def parse_header(data: bytes) -> PlyHeader:
    """Read the header of a PLY file. Raises `FormatError` where it breaks the format."""
    if not data.startswith(b"ply"):
        raise FormatError("the file does not start with a line 'ply'")
    order: str | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    for number, found in enumerate(_LINE.finditer(data), 1):
        words = found[1].decode("latin-1").split()
        keyword = words[0] if words else ""
        if number == 1:
            if words != ["ply"]:
                raise FormatError("the file does not start with a line 'ply'")
        elif keyword == "end_header":
            return _header(data, order, elements, found)
        elif keyword == "format":
            order = _order(words, number)
        elif keyword == "element":
            elements.append(_element(words, number, len(data)))
        elif keyword == "property":
            if not elements:
                raise FormatError(f"line {number} has a property before any element")
            elements[-1][2].append(_property(words, number, order or ""))
        # Comments and whatever else a line may say are kept and not read.
        if number > _MAX_LINES:
            break
    raise FormatError("the header has no line 'end_header'")


def _header(
    data: bytes, order: str | None, elements: list[tuple[str, int, list[Property]]], end: re.Match[bytes]
) -> PlyHeader:
    if order is None:
        raise FormatError("the header has no line 'format'")
    size = end.end()
    # With lines ending in a bare return, a line feed behind the header is the first byte of the data.
    if end[2] == b"\r\n" and order and not data.startswith((b"ply\r\n", b"ply \r\n")):
        size -= 1
    names = [name for name, _, _ in elements]
    if len(set(names)) != len(names):
        raise FormatError("the header declares an element twice")
    for name, _, properties in elements:
        if len({entry.name for entry in properties}) != len(properties):
            raise FormatError(f"the header declares a property of '{name[:40]}' twice")
    return PlyHeader(
        order=order,
        elements=tuple(
            Element(name=name, rows=rows, properties=tuple(all_)) for name, rows, all_ in elements
        ),
        size=size,
    )


def _order(words: list[str], number: int) -> str:
    if len(words) != 3 or words[1] not in _ORDERS or words[2] != "1.0":
        raise FormatError(
            f"line {number} declares '{' '.join(words)[:60]}', expected 'format ascii 1.0' or binary"
        )
    return _ORDERS[words[1]]


def _element(words: list[str], number: int, size: int) -> tuple[str, int, list[Property]]:
    if len(words) != 3 or not words[2].isascii() or not words[2].isdigit():
        raise FormatError(f"line {number} has '{' '.join(words)[:60]}', expected 'element NAME COUNT'")
    # Every row takes a byte at least. Long numbers are not even converted.
    if len(words[2]) > 18 or int(words[2]) > size:
        raise FormatError(
            f"line {number} declares {words[2][:40]} rows of {words[1][:40]}, more than the file can hold"
        )
    return words[1], int(words[2]), []


def _property(words: list[str], number: int, order: str) -> Property:
    listed = len(words) == 5 and words[1] == "list"
    types = words[2:4] if listed else words[1:2]
    if not (listed or len(words) == 3) or any(name not in _TYPES for name in types):
        raise FormatError(
            f"line {number} has '{' '.join(words)[:60]}', expected 'property TYPE NAME' with a known type"
        )
    dtypes = [np.dtype(order + _TYPES[name]) for name in types]
    if listed and dtypes[0].kind == "f":
        raise FormatError(f"line {number} counts a list in {types[0]}, expected a whole-number type")
    return Property(name=words[-1], dtype=dtypes[-1], count=dtypes[0] if listed else None)

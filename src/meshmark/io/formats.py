"""The table of file formats: how each is recognised, read, and written afresh."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from meshmark.document import Attributes, Document
from meshmark.errors import InputError
from meshmark.late import late_function
from meshmark.mesh import FloatArray, IntArray

__all__ = ["FORMATS", "OTHER_NAMES", "Format", "check_extension", "detect_format", "format_of_name"]

Converted = tuple[dict[str, bytes], tuple[str, ...]]

# How much of a file is looked at to recognise it.
_HEAD = 65536

_PLY = re.compile(rb"ply[ \t]*[\r\n]")
_OFF = re.compile(
    rb"(?:\xef\xbb\xbf)?(?:\s|#[^\r\n]*[\r\n])*(?:(?:ST)?C?N?4?n?OFF|(?:st)?c?n?off)(?![A-Za-z_])"
)
_SOLID = re.compile(rb"(?:^|[\r\n])(?:\xef\xbb\xbf)?[ \t]*solid\b", re.IGNORECASE)
_FACET = re.compile(rb"[\r\n][ \t]*(?:facet|endsolid)\b", re.IGNORECASE)
_OBJ = re.compile(rb"(?:^|[\r\n])[ \t]*v[ \t]+[-+.0-9]")
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*\{")
_GLB, _ZIP = re.compile(rb"glTF"), re.compile(rb"PK\x03\x04")


@dataclass(frozen=True, kw_only=True)
class Format:
    """One file format.

    extensions: lower case, with the dot; the first is the usual one.
    sniff:      True where the first 64 kB and the length of a file are clearly this format.
    parse:      (bytes, path) -> Document; raises `FormatError`. The path serves messages and side files.
    convert:    (vertices, faces, attributes, name) -> (files by name, names of what was dropped).
    keeps:      the fields of `Attributes` that the format can hold.
    """

    name: str
    extensions: tuple[str, ...]
    sniff: Callable[[bytes, int], bool]
    parse: Callable[[bytes, Path], Document]
    convert: Callable[[FloatArray, IntArray, Attributes, str], Converted]
    keeps: frozenset[str]


def _matches(pattern: re.Pattern[bytes]) -> Callable[[bytes, int], bool]:
    return lambda head, _size: pattern.match(head) is not None


def _looks_like_obj(head: bytes, _size: int) -> bool:
    return _OBJ.search(head) is not None and b"\0" not in head


def _looks_like_stl(head: bytes, size: int) -> bool:
    # A binary STL has no magic: its length must agree with its count of 50-byte facets.
    facets = int.from_bytes(head[80:84], "little") if size >= 84 else 0
    text = _FACET.search(head) is not None and _SOLID.search(head) is not None and b"\0" not in head
    return text or (facets > 0 and size == 84 + 50 * facets)


_ALL = frozenset({"normals", "texcoords", "colors"})

# In the order in which content is tried: formats with a magic number first, the loosest last. The modules of a
# format are imported when one of its files is read or written.
FORMATS: dict[str, Format] = {
    entry.name: entry
    for entry in (
        Format(
            name="glb",
            extensions=(".glb",),
            sniff=_matches(_GLB),
            parse=late_function("meshmark.io.gltf.parse", "parse_glb"),
            convert=late_function("meshmark.io.gltf.convert", "convert_glb"),
            keeps=_ALL,
        ),
        Format(
            name="3mf",
            extensions=(".3mf",),
            sniff=_matches(_ZIP),
            parse=late_function("meshmark.io.threemf.parse", "parse_3mf"),
            convert=late_function("meshmark.io.threemf.convert", "convert_3mf"),
            keeps=frozenset(),
        ),
        Format(
            name="ply",
            extensions=(".ply",),
            sniff=_matches(_PLY),
            parse=late_function("meshmark.io.ply.parse", "parse_ply"),
            convert=late_function("meshmark.io.ply.convert", "convert_ply"),
            keeps=_ALL,
        ),
        Format(
            name="off",
            extensions=(".off",),
            sniff=_matches(_OFF),
            parse=late_function("meshmark.io.off.parse", "parse_off"),
            convert=late_function("meshmark.io.off.convert", "convert_off"),
            keeps=_ALL,
        ),
        Format(
            name="gltf",
            extensions=(".gltf",),
            sniff=_matches(_JSON),
            parse=late_function("meshmark.io.gltf.parse", "parse_gltf"),
            convert=late_function("meshmark.io.gltf.convert", "convert_gltf"),
            keeps=_ALL,
        ),
        Format(
            name="stl",
            extensions=(".stl",),
            sniff=_looks_like_stl,
            parse=late_function("meshmark.io.stl.parse", "parse_stl"),
            convert=late_function("meshmark.io.stl.convert", "convert_stl"),
            keeps=frozenset(),
        ),
        Format(
            name="obj",
            extensions=(".obj",),
            sniff=_looks_like_obj,
            parse=late_function("meshmark.io.obj.parse", "parse_obj"),
            convert=late_function("meshmark.io.obj.convert", "convert_obj"),
            keeps=_ALL,
        ),
    )
}


# Extensions of other programs' files that are one of these formats to the byte; as input and as output.
OTHER_NAMES: dict[str, str] = {
    ".vrm": "glb",  # avatars: a GLB with extensions of its own, all of which a save keeps
}


def format_of_name(path: Path) -> Format | None:
    """Return the format that a file name's extension stands for (a final `.gz` is set aside), or None."""
    extension = _extension(path)
    if extension in OTHER_NAMES:
        return FORMATS[OTHER_NAMES[extension]]
    return next((entry for entry in FORMATS.values() if extension in entry.extensions), None)


def check_extension(path: Path, source: Path | None = None) -> None:
    """Raise `InputError` where the extension of an output stands for a format that is not written.

    A name without an extension is fine, and so is the extension that the input, `source`, has: what is in such a
    file is known, and the output holds the same.
    """
    extension = _extension(path)
    if not extension or format_of_name(path) is not None:
        return
    if source is None or extension != _extension(source):
        raise InputError(
            f"cannot write {path}: '{extension}' is not the extension of a format that meshmark writes, expected "
            f"one of {_known_extensions()}, also .gz"
        )


def _extension(path: Path) -> str:
    """Return the last extension of a name, in lower case and with the dot; empty where there is none."""
    return Path(path.name.lower().removesuffix(".gz")).suffix


def _known_extensions() -> str:
    return " ".join([*(entry.extensions[0] for entry in FORMATS.values()), *OTHER_NAMES])


def detect_format(data: bytes, path: Path) -> Format:
    """Return the format of a file from its content, and from its name where the content does not tell.

    Raises `InputError` where neither does.
    """
    named, head = format_of_name(path), data[:_HEAD]
    if named is not None and named.sniff(head, len(data)):
        return named
    found = next((entry for entry in FORMATS.values() if entry.sniff(head, len(data))), named)
    if found is None:
        raise InputError(
            f"{path} is not a model file in a known format, expected one of {_known_extensions()}, also .gz"
        )
    return found

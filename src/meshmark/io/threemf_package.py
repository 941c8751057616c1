"""The zip package around a 3MF model: finding and reading its parts, with limits against zip bombs."""

from __future__ import annotations

import io
import posixpath
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from meshmark.errors import FormatError
from meshmark.io.xml_text import walk_xml
from meshmark.io.zip_patch import replace_members

__all__ = ["Package", "open_package", "part_name"]

_RELATIONSHIP = "http://schemas.openxmlformats.org/package/2006/relationships Relationship"
_MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_USUAL_MODEL = "3D/3dmodel.model"

# XML of numbers shrinks up to twentyfold; a small part that grows beyond both limits is a trap.
_MOST_BYTES, _ALWAYS_ALLOWED, _MOST_GROWTH = 2 << 30, 64 << 20, 200
_MOST_MEMBERS = 65_536
_ENCRYPTED = 0x1


@dataclass(frozen=True, eq=False)
class Package:
    """A zip file: its bytes, its directory, and member names by their lower-case form."""

    data: bytes
    archive: zipfile.ZipFile
    names: Mapping[str, list[zipfile.ZipInfo]]

    def has(self, part: str) -> bool:
        """Whether there is a part of this name; part names ignore case."""
        return part.lower() in self.names

    def read(self, part: str) -> bytes:
        """Return the bytes of a part. Raises `FormatError` where it is absent, damaged or too large."""
        item = self.member(part)
        limit = min(max(_ALWAYS_ALLOWED, _MOST_GROWTH * item.compress_size), _MOST_BYTES)
        if item.flag_bits & _ENCRYPTED:
            raise FormatError(f"{part} is encrypted, expected plain content")
        if item.file_size > limit:
            raise FormatError(f"{part} unpacks to {item.file_size} bytes, which no model of its size does")
        try:
            return self.archive.read(item)
        except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, OSError, ValueError) as error:
            raise FormatError(f"{part} in the 3MF package is damaged ({error})") from None

    def member(self, part: str) -> zipfile.ZipInfo:
        """Return the directory entry of a part."""
        found = self.names.get(part.lower(), [])
        if len(found) != 1:
            times = "twice" if found else "not"
            raise FormatError(f"the part {part} is {times} in the 3MF package, expected once")
        return found[0]

    def main_model(self) -> str:
        """Return the name of the part that the package says is its model."""
        targets: list[str] = []

        def start(tag: str, attributes: Mapping[str, str], _: int) -> None:
            if tag == _RELATIONSHIP and attributes.get("Type") == _MODEL_TYPE:
                targets.append(attributes.get("Target", ""))

        if self.has("_rels/.rels"):
            walk_xml(self.read("_rels/.rels"), "_rels/.rels", start, lambda _: None)
        name = part_name(targets[0]) if targets else _USUAL_MODEL
        return self.member(name).filename

    def with_parts(self, contents: Mapping[str, bytes]) -> bytes:
        """Return the package with new contents for some parts, all else byte for byte."""
        members = {self.member(part).filename: content for part, content in contents.items()}
        return replace_members(self.data, self.archive, members) if members else self.data


def part_name(target: str) -> str:
    """Return a part's name in the zip file from its address in the package ("/3D/a.model")."""
    return posixpath.normpath(target.strip()).lstrip("/")


def open_package(data: bytes) -> Package:
    """Read the directory of a zip file. Raises `FormatError`."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except (zipfile.BadZipFile, NotImplementedError, OSError, ValueError, OverflowError, EOFError) as error:
        raise FormatError(f"the 3MF package is not a readable zip file ({error})") from None
    members = archive.infolist()
    if len(members) > _MOST_MEMBERS:
        raise FormatError(f"the 3MF package has {len(members)} members, expected at most {_MOST_MEMBERS}")
    names: dict[str, list[zipfile.ZipInfo]] = {}
    for item in members:
        names.setdefault(item.filename.lower(), []).append(item)
    return Package(data, archive, names)

"""A zip file's members: finding, reading and replacing them, with limits against zip bombs."""

from __future__ import annotations

import io
import lzma
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import unquote

from meshmark.errors import FormatError
from meshmark.io.zip_patch import replace_members

__all__ = ["Package", "open_package"]

# Text of numbers shrinks up to twentyfold; a small member that grows beyond both limits is a trap.
_MOST_BYTES, _ALWAYS_ALLOWED, _MOST_GROWTH = 2 << 30, 64 << 20, 200
_MOST_MEMBERS = 65_536
_ENCRYPTED = 0x1
_DAMAGE = (zipfile.BadZipFile, NotImplementedError, OSError, ValueError, OverflowError, EOFError, zlib.error)


@dataclass(frozen=True, eq=False, kw_only=True)
class Package:
    """A zip file.

    kind:  what it is, for messages: "3MF package".
    data:  its bytes; archive: its directory.
    names: members by their lower-case names; loose: by these with escapes and backslashes made plain.
    """

    kind: str
    data: bytes
    archive: zipfile.ZipFile
    names: Mapping[str, list[zipfile.ZipInfo]]
    loose: Mapping[str, list[zipfile.ZipInfo]]

    def has(self, part: str) -> bool:
        """Whether there is a member of this name, upper and lower case and escapes aside."""
        return bool(self._found(part))

    def read(self, part: str) -> bytes:
        """Return the bytes of a member. Raises `FormatError` where it is absent, damaged or too large."""
        item = self.member(part)
        limit = min(max(_ALWAYS_ALLOWED, _MOST_GROWTH * item.compress_size), _MOST_BYTES)
        if item.flag_bits & _ENCRYPTED:
            raise FormatError(f"{part} is encrypted, expected plain content")
        if item.file_size > limit:
            raise FormatError(f"{part} unpacks to {item.file_size} bytes, which no model of its size does")
        try:
            return self.archive.read(item)
        except NotImplementedError:
            raise FormatError(
                f"{part} is packed with method {item.compress_type}, expected deflate, bzip2 or LZMA"
            ) from None
        except (*_DAMAGE, lzma.LZMAError) as error:
            raise FormatError(f"{part} in the {self.kind} is damaged ({error})") from None

    def member(self, part: str) -> zipfile.ZipInfo:
        """Return the directory entry of a member. Raises `FormatError` unless there is one."""
        found = self._found(part)
        if len(found) != 1:
            times = "twice" if found else "not"
            raise FormatError(f"the part {part} is {times} in the {self.kind}, expected once")
        return found[0]

    def with_parts(self, contents: Mapping[str, bytes]) -> bytes:
        """Return the zip file with new contents for some members, all else byte for byte."""
        members = {self.member(part).filename: content for part, content in contents.items()}
        return replace_members(self.data, self.archive, members) if members else self.data

    def _found(self, part: str) -> list[zipfile.ZipInfo]:
        return self.names.get(part.lower()) or self.loose.get(_plain(part), [])


def _plain(name: str) -> str:
    return unquote(name).replace("\\", "/").lower()


def open_package(data: bytes, kind: str = "3MF package") -> Package:
    """Read the directory of a zip file. Raises `FormatError`."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except _DAMAGE as error:
        raise FormatError(f"the {kind} is not a readable zip file ({error})") from None
    members = archive.infolist()
    if len(members) > _MOST_MEMBERS:
        raise FormatError(f"the {kind} has {len(members)} members, expected at most {_MOST_MEMBERS}")
    names: dict[str, list[zipfile.ZipInfo]] = {}
    loose: dict[str, list[zipfile.ZipInfo]] = {}
    for item in members:
        names.setdefault(item.filename.lower(), []).append(item)
        loose.setdefault(_plain(item.filename), []).append(item)
    return Package(kind=kind, data=data, archive=archive, names=names, loose=loose)

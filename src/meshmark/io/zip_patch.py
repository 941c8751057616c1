"""Replace the content of some members of a zip file; every other byte of it stays as it is.

`zipfile` can only write archives afresh, which loses extra fields, flags and the compressed bytes of the
other members. Here the records are patched in place. Layout: PKWARE APPNOTE 6.3.10, sections 4.3 and 4.5.3.
"""

from __future__ import annotations

import bz2
import lzma
import struct
import zipfile
import zlib
from collections.abc import Mapping

from meshmark.errors import FormatError

__all__ = ["replace_members"]

_CENTRAL, _END, _DESCRIPTOR = b"PK\x01\x02", b"PK\x05\x06", b"PK\x07\x08"
_END64, _LOCATOR64 = b"PK\x06\x06", b"PK\x06\x07"
_HAS_DESCRIPTOR = 0x8
# Of LZMA data, that a mark ends them; ours always have one. Section 5.8: version, length and bytes of properties.
_HAS_END_MARK = 0x2
_LZMA = {"id": lzma.FILTER_LZMA1, "dict_size": 1 << 23, "lc": 3, "lp": 0, "pb": 2}
_LZMA_HEAD = struct.pack("<BBHBI", 9, 4, 5, (2 * 5 + 0) * 9 + 3, 1 << 23)
_WIDE = 0xFFFFFFFF

# Places of (crc, compressed size, size, name length, fixed part) in the two kinds of header.
_LOCAL_FIELDS = (14, 18, 22, 26, 30)
_CENTRAL_FIELDS = (16, 20, 24, 28, 46)


def replace_members(data: bytes, archive: zipfile.ZipFile, contents: Mapping[str, bytes]) -> bytes:
    """Return the zip file with new contents for the members named, compressed by their own method.

    Raises `FormatError` for layouts it cannot patch.
    """
    try:
        return _replaced(data, archive, contents)
    except (struct.error, IndexError):
        raise FormatError("the zip file's records do not fit its bytes") from None


def _replaced(data: bytes, archive: zipfile.ZipFile, contents: Mapping[str, bytes]) -> bytes:
    members = sorted(archive.infolist(), key=lambda item: item.header_offset)
    ends = [item.header_offset for item in members[1:]] + [archive.start_dir]
    pieces, offsets, packed, at = [data[: members[0].header_offset]], {}, {}, members[0].header_offset
    for item, end in zip(members, ends, strict=True):
        record = data[item.header_offset : end]
        if len(record) < 30 + item.compress_size:
            raise FormatError(f"{item.filename} overlaps another member of the zip file")
        if item.filename in contents:
            new = contents[item.filename]
            body = _compressed(new, item)
            packed[item.header_offset] = (zlib.crc32(new), len(body), len(new))
            record = _member(record, item, body, packed[item.header_offset])
        offsets[item.header_offset] = at
        pieces.append(record)
        at += len(record)
    directory = _directory(data, archive.start_dir, len(members), offsets, packed)
    tail = _tail(data[archive.start_dir + len(directory) :], at, at - archive.start_dir)
    return b"".join([*pieces, directory, tail])


def _compressed(content: bytes, item: zipfile.ZipInfo) -> bytes:
    if item.compress_type == zipfile.ZIP_STORED:
        return content
    if item.compress_type == zipfile.ZIP_BZIP2:
        return bz2.compress(content)
    if item.compress_type == zipfile.ZIP_LZMA:
        return _LZMA_HEAD + lzma.compress(content, lzma.FORMAT_RAW, filters=[_LZMA])
    if item.compress_type != zipfile.ZIP_DEFLATED:
        raise FormatError(f"{item.filename} is packed with method {item.compress_type}, expected deflate")
    packer = zlib.compressobj(6, zlib.DEFLATED, -zlib.MAX_WBITS)
    return packer.compress(content) + packer.flush()


def _member(record: bytes, item: zipfile.ZipInfo, body: bytes, numbers: tuple[int, int, int]) -> bytes:
    name_size, extra_size = struct.unpack_from("<HH", record, 26)
    start = 30 + name_size + extra_size
    header, rest = bytearray(record[:start]), bytearray(record[start + item.compress_size :])
    if item.compress_type == zipfile.ZIP_LZMA:
        header[6] |= _HAS_END_MARK
    if item.flag_bits & _HAS_DESCRIPTOR:
        _put_descriptor(rest, item.filename, numbers)
    if not item.flag_bits & _HAS_DESCRIPTOR or header[14:26] != bytes(12):
        _put_numbers(header, _LOCAL_FIELDS, numbers)
    return bytes(header) + body + bytes(rest)


def _put_descriptor(rest: bytearray, name: str, numbers: tuple[int, int, int]) -> None:
    start = 4 if rest[:4] == _DESCRIPTOR else 0
    layout = "<IQQ" if len(rest) - start >= 20 else "<III"
    if len(rest) - start < struct.calcsize(layout):
        raise FormatError(f"{name}: the sizes that should follow its data are missing")
    struct.pack_into(layout, rest, start, *numbers)


def _put_numbers(header: bytearray, fields: tuple[int, ...], numbers: tuple[int, int, int]) -> None:
    """Write checksum and sizes; a size that the header marks as too wide lies in its zip64 field."""
    crc, small, full = numbers
    crc_at, small_at, full_at, lengths_at, fixed = fields
    struct.pack_into("<I", header, crc_at, crc)
    wide = _zip64_field(header, lengths_at, fixed)
    for place, value in ((full_at, full), (small_at, small)):
        if struct.unpack_from("<I", header, place)[0] == _WIDE:
            struct.pack_into("<Q", header, wide, value)
            wide += 8
        else:
            struct.pack_into("<I", header, place, value)


def _zip64_field(header: bytearray, lengths_at: int, fixed: int) -> int:
    """Return where the numbers of the zip64 extra field start, or where the header ends."""
    name_size, extra_size = struct.unpack_from("<HH", header, lengths_at)
    at, end = fixed + name_size, fixed + name_size + extra_size
    while at + 4 <= end:
        kind, size = struct.unpack_from("<HH", header, at)
        if kind == 1:
            return int(at + 4)
        at += int(4 + size)
    return len(header)


def _directory(
    data: bytes,
    start: int,
    count: int,
    offsets: Mapping[int, int],
    packed: Mapping[int, tuple[int, int, int]],
) -> bytes:
    records, at = [], start
    for _ in range(count):
        if data[at : at + 4] != _CENTRAL:
            raise FormatError(f"the zip directory is broken at byte {at}")
        sizes = struct.unpack_from("<HHH", data, at + 28)
        record = bytearray(data[at : at + 46 + sum(sizes)])
        at += len(record)
        place, layout = _offset_place(record)
        old = struct.unpack_from(layout, record, place)[0]
        if old in packed:
            _put_numbers(record, _CENTRAL_FIELDS, packed[old])
            if struct.unpack_from("<H", record, 10)[0] == zipfile.ZIP_LZMA:
                record[8] |= _HAS_END_MARK
        if old not in offsets:
            raise FormatError(
                "the zip directory has data before it that is not counted, as self-extracting files do"
            )
        struct.pack_into(layout, record, place, offsets[old])
        records.append(bytes(record))
    return b"".join(records)


def _offset_place(record: bytearray) -> tuple[int, str]:
    if struct.unpack_from("<I", record, 42)[0] != _WIDE:
        return 42, "<I"
    wide = [struct.unpack_from("<I", record, place)[0] == _WIDE for place in (24, 20)]
    return _zip64_field(record, 28, 46) + 8 * sum(wide), "<Q"


def _tail(tail: bytes, start: int, shift: int) -> bytes:
    """Return what follows the directory, pointing to where the directory starts now."""
    patched = bytearray(tail)
    if tail[:4] == _END64:
        struct.pack_into("<Q", patched, 48, start)
        locator = tail.find(_LOCATOR64)
        if locator >= 0:
            old = struct.unpack_from("<Q", patched, locator + 8)[0]
            struct.pack_into("<Q", patched, locator + 8, old + shift)
    end = tail.find(_END)
    if end < 0:
        raise FormatError("the zip file has no end record after its directory")
    if struct.unpack_from("<I", patched, end + 16)[0] != _WIDE:
        struct.pack_into("<I", patched, end + 16, start)
    return bytes(patched)

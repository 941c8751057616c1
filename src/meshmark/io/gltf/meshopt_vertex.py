"""Decoder of meshopt's vertex codec: mode ATTRIBUTES of EXT_meshopt_compression and KHR_meshopt_compression.

Rows of `stride` bytes are coded byte column by byte column, in blocks of at most 256 rows. A column of a block is
groups of 16 bytes, each stored with 0, 1, 2, 4 or 8 bits a byte; a byte whose bits are all ones follows in full
behind its group. The bytes are differences from row to row. Version 0 is that of the EXT extension, version 1 adds
a control byte for four columns and channels of 2 and 4 bytes.

A first pass in Python finds where the groups lie, which needs no more than counting the escaped bytes; numpy then
unpacks all groups at once. Source: the specification of the two extensions (Khronos glTF registry); tests compare
with meshoptimizer's own output.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError

__all__ = ["decode_vertices"]

_HEADER = 0xA0
_GROUP = 16
_BLOCK_BYTES, _BLOCK_ROWS = 8192, 256
# The shortest tail of a stream, by version; a group takes 24 bytes at most, so none that starts before ends behind.
_TAIL = {0: 32, 1: 24}
_GROUP_LIMIT = 24
# Bits per byte for the four 2-bit codes of a group, by control code; version 0 knows only the last.
_BITS = {0: (0, 1, 2, 4), 1: (1, 2, 4, 8), None: (0, 2, 4, 8)}
_ZEROS, _LITERAL = 2, 3

Bytes = NDArray[np.uint8]


def decode_vertices(data: bytes, count: int, stride: int) -> Bytes:
    """Return the rows (count, stride), uint8, of a stream; stride: 4 to 256, a multiple of 4.

    Raises `FormatError` where the bytes are no such stream of exactly `count` rows.
    """
    version = data[0] - _HEADER if data else -1
    if version not in _TAIL:
        raise FormatError("a meshopt stream of attributes does not start with its header byte, 0xa0 or 0xa1")
    tail = stride + (stride // 4 if version else 0)
    padded = max(tail, _TAIL[version])
    if len(data) < 1 + padded:
        raise FormatError("a meshopt stream of attributes ends before its first row")
    source = np.frombuffer(data, np.uint8)
    found = _Groups.scan(data, source, (count, stride), version)
    if len(data) - found.end != padded:
        raise FormatError("a meshopt stream of attributes is longer than its rows")
    deltas = found.unpacked(source, count, stride)
    first = source[len(data) - tail : len(data) - tail + stride]
    channels = bytes(data[len(data) - stride // 4 :]) if version else bytes(stride // 4)
    rows = np.empty((count, stride), np.uint8)
    for lane, channel in enumerate(channels):
        columns = slice(4 * lane, 4 * lane + 4)
        rows[:, columns] = _summed(deltas[columns], first[columns], channel)
    return rows


@dataclass(frozen=True, eq=False, kw_only=True)
class _Stream:
    """What a walk through a stream looks at.

    escapes: for 1, 2 and 4 bits how many escapes lie before each byte; last: the last place a group can start at.
    """

    data: bytes
    escapes: dict[int, memoryview]
    last: int


@dataclass(eq=False, kw_only=True)
class _Groups:
    """Where the groups of each width lie: for 1, 2, 4 and 8 bits the places in the stream and the numbers.

    A group's number is column * (groups per column) + its place in the column.
    literals: (column, row, place, rows) of what is stored as it is.
    """

    places: dict[int, list[int]] = field(default_factory=lambda: {1: [], 2: [], 4: [], 8: []})
    numbers: dict[int, list[int]] = field(default_factory=lambda: {1: [], 2: [], 4: [], 8: []})
    literals: list[tuple[int, int, int, int]] = field(default_factory=list)
    end: int = 1

    @classmethod
    def scan(cls, data: bytes, source: Bytes, shape: tuple[int, int], version: int) -> _Groups:
        """Walk through the stream; raises `FormatError` where it ends too soon."""
        count, stride = shape
        found = cls()
        stream = _Stream(data=data, escapes=_escapes(source), last=len(data) - _GROUP_LIMIT)
        block = min(_BLOCK_BYTES // stride // _GROUP * _GROUP, _BLOCK_ROWS)
        per_column = -(-count // _GROUP)
        at = 1
        for start in range(0, count, block):
            rows = min(block, count - start)
            controls = data[at : at + stride // 4] if version else b""
            at += len(controls)
            for column in range(stride):
                control = controls[column // 4] >> 2 * (column % 4) & 3 if controls else None
                if control == _LITERAL:
                    found.literals.append((column, start, at, rows))
                    at += rows
                elif control != _ZEROS:
                    first = column * per_column + start // _GROUP
                    groups = -(-rows // _GROUP)
                    at = found._column(stream, at, (first, groups), _BITS[control])
                if at > len(data):
                    raise FormatError("a meshopt stream of attributes is cut off")
        found.end = at
        return found

    def _column(self, stream: _Stream, at: int, span: tuple[int, int], widths: tuple[int, ...]) -> int:
        """Note the groups of one column of a block, whose header lies at `at`; return where they end."""
        data, escapes, last = stream.data, stream.escapes, stream.last
        first, groups = span
        header = at
        at += -(-groups // 4)
        places, numbers = self.places, self.numbers
        for group in range(groups):
            if at > last:
                raise FormatError("a meshopt stream of attributes is cut off")
            bits = widths[data[header + (group >> 2)] >> 2 * (group & 3) & 3]
            if not bits:
                continue
            places[bits].append(at)
            numbers[bits].append(first + group)
            if bits == 8:
                at += _GROUP
            else:
                count = escapes[bits]
                at += 2 * bits
                at += count[at] - count[at - 2 * bits]
        return at

    def unpacked(self, source: Bytes, count: int, stride: int) -> Bytes:
        """Return the differences (stride, count) that the groups hold."""
        groups = -(-count // _GROUP)
        out = np.zeros((stride * groups, _GROUP), np.uint8)
        for bits, found in self.places.items():
            if not found:
                continue
            place, number = np.array(found), np.array(self.numbers[bits])
            for start in range(0, len(place), 1 << 18):
                chunk = slice(start, start + (1 << 18))
                out[number[chunk]] = _group_bytes(source, place[chunk], bits)
        flat = out.reshape(stride, groups * _GROUP)
        for column, row, place_, rows in self.literals:
            flat[column, row : row + rows] = source[place_ : place_ + rows]
        return flat[:, :count]


def _escapes(source: Bytes) -> dict[int, memoryview]:
    """Return for 1, 2 and 4 bits how many escapes lie before each byte of the stream."""
    values = np.arange(256)
    found = {}
    for bits in (1, 2, 4):
        full = (1 << bits) - 1
        per_byte = sum((values >> shift & full) == full for shift in range(0, 8, bits)).astype(np.uint8)
        total = np.zeros(len(source) + 1, np.uint32)
        np.cumsum(per_byte[source], out=total[1:], dtype=np.uint32)
        found[bits] = memoryview(total.tobytes()).cast("I")
    return found


def _group_bytes(source: Bytes, place: NDArray[np.int64], bits: int) -> Bytes:
    """Return the bytes (groups, 16) of groups that lie at these places."""
    if bits == 8:
        plain: Bytes = source[place[:, None] + np.arange(_GROUP)]
        return plain
    packed = source[place[:, None] + np.arange(2 * bits)]
    # The first value lies in the highest bits, but of single bits in the lowest.
    shifts = np.arange(8) if bits == 1 else np.arange(8 - bits, -1, -bits)
    full = (1 << bits) - 1
    values = (packed[:, :, None] >> shifts.astype(np.uint8) & full).reshape(len(place), _GROUP)
    escaped = values == full
    behind = place[:, None] + 2 * bits + np.cumsum(escaped, axis=1) - 1
    whole: Bytes = np.where(escaped, source[np.minimum(behind, len(source) - 1)], values).astype(np.uint8)
    return whole


def _summed(deltas: Bytes, first: Bytes, channel: int) -> Bytes:
    """Return four columns (count, 4) from their differences (4, count) and the first row."""
    kind, turn = channel & 3, channel >> 4
    if kind == 3:
        raise FormatError("a meshopt stream of attributes has an unknown channel")
    width = (1, 2, 4)[kind]
    dtype = np.dtype(f"<u{width}")
    # Little-endian words of `width` neighbouring columns.
    words = np.ascontiguousarray(deltas.T).view(dtype)
    start = np.ascontiguousarray(first).view(dtype)
    if kind == 2:
        back = (32 - turn) & 31
        words = words << np.uint32(back) | words >> np.uint32((32 - back) & 31)
        out = np.bitwise_xor.accumulate(np.vstack([start, words]), axis=0)[1:]
    else:
        signed = (words >> dtype.type(1)) ^ (np.zeros_like(words) - (words & dtype.type(1)))
        out = np.cumsum(signed, axis=0, dtype=dtype) + start
    return np.ascontiguousarray(out, dtype).view(np.uint8).reshape(-1, 4)

"""Decoders of meshopt's index codecs: modes TRIANGLES and INDICES of the meshopt compression extensions.

TRIANGLES names most corners by their place in two queues: the 16 edges and the 16 vertices seen last. INDICES is a
sequence of differences to one of two running indices. Indices are uint32 and wrap around as in the reference.
Source: the specification of EXT_meshopt_compression (Khronos glTF registry); tests compare with meshoptimizer.
"""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError

__all__ = ["decode_sequence", "decode_triangles"]

_TRIANGLES, _SEQUENCE = 0xE0, 0xD0
_QUEUE = 16
_MASK = 0xFFFFFFFF
# The queues are lists that grow at their end and are cut back to what can still be named this often.
_CUT = 1 << 16


def decode_triangles(data: bytes, count: int) -> NDArray[np.uint32]:
    """Return the `count` corner indices, a multiple of 3. Raises `FormatError` for any other stream."""
    version = data[0] - _TRIANGLES if data else -1
    if version not in (0, 1) or count % 3:
        raise FormatError("a meshopt stream of triangles does not start with its header byte, 0xe0 or 0xe1")
    faces = count // 3
    end = len(data) - _QUEUE  # a table of 16 pairs of codes closes the stream
    if end < 1 + faces:
        raise FormatError("a meshopt stream of triangles is cut off")
    reader = _Triangles(data, 1 + faces, end, 13 if version else 15)
    for start in range(0, faces, _CUT):
        reader.read(data[1 + start : 1 + min(start + _CUT, faces)])
    if reader.at != end:
        raise FormatError("a meshopt stream of triangles is longer or shorter than its triangles")
    return np.frombuffer(reader.out, np.uint32)


class _Triangles:
    """The state of the decoder between runs of triangles."""

    def __init__(self, data: bytes, at: int, end: int, fixed: int) -> None:
        self.data, self.at, self.end, self.fixed = data, at, end, fixed
        self.from_, self.to, self.seen = [_MASK] * _QUEUE, [_MASK] * _QUEUE, [_MASK] * _QUEUE
        self.next, self.last = 0, 0
        self.out = array("I")

    def read(self, codes: bytes) -> None:
        """Read one triangle for each code."""
        from_, to, seen = self.from_[-_QUEUE:], self.to[-_QUEUE:], self.seen[-_QUEUE:]
        next_, fixed, end, table = self.next, self.fixed, self.end, self.data[self.end :]
        out = array("I")
        for code in codes:
            if self.at > end:
                raise FormatError("a meshopt stream of triangles is cut off")
            if code < 0xF0:  # an edge of the queue and one more corner
                edge, corner = -1 - (code >> 4), code & 15
                a, b = from_[edge], to[edge]
                if not corner:
                    c = next_
                    next_ += 1
                    seen.append(c)
                elif corner < fixed:
                    c = seen[-1 - corner]
                else:
                    c = self._free() if corner == 15 else (self.last + (-1 if corner == 13 else 1)) & _MASK
                    self.last = c
                    seen.append(c)
                from_ += (c, a)
                to += (b, c)
            else:  # three corners
                if code < 0xFE:
                    pair, own = table[code & 15], False
                else:
                    pair, own = self._byte(), code == 0xFF
                    next_ = next_ if pair else 0
                second, third = pair >> 4, pair & 15
                a = b = c = 0
                if not own:
                    a, next_ = next_, next_ + 1
                if not second:
                    b, next_ = next_, next_ + 1
                elif second < 15 or code < 0xFE:
                    b = seen[-second]
                if not third:
                    c, next_ = next_, next_ + 1
                elif third < 15 or code < 0xFE:
                    c = seen[-third]
                if code >= 0xFE:
                    if own:
                        a = self.last = self._free()
                    if second == 15:
                        b = self.last = self._free()
                    if third == 15:
                        c = self.last = self._free()
                seen.append(a)
                if not second or (second == 15 and code >= 0xFE):
                    seen.append(b)
                if not third or (third == 15 and code >= 0xFE):
                    seen.append(c)
                from_ += (b, c, a)
                to += (a, b, c)
            out.extend((a, b, c))
        self.from_, self.to, self.seen, self.next = from_, to, seen, next_
        self.out += out

    def _byte(self) -> int:
        if self.at >= len(self.data):
            raise FormatError("a meshopt stream of triangles is cut off")
        value = self.data[self.at]
        self.at += 1
        return value

    def _free(self) -> int:
        """Return an index given by its difference to the last one given so."""
        value, self.at = _number(self.data, self.at)
        return (self.last + (value >> 1 ^ -(value & 1))) & _MASK


def _number(data: bytes, at: int) -> tuple[int, int]:
    """Return a number of up to five bytes of 7 bits each, lowest first, and where it ends."""
    value, shift = 0, 0
    for place in range(at, at + 5):
        if place >= len(data):
            raise FormatError("a meshopt stream of indices is cut off")
        value |= (data[place] & 127) << shift
        shift += 7
        if data[place] < 128:
            return value & _MASK, place + 1
    return value & _MASK, at + 5


def decode_sequence(data: bytes, count: int) -> NDArray[np.uint32]:
    """Return the `count` indices of a sequence. Raises `FormatError` for any other stream."""
    version = data[0] - _SEQUENCE if data else -1
    if version not in (0, 1):
        raise FormatError("a meshopt stream of indices does not start with its header byte, 0xd0 or 0xd1")
    end = len(data) - 4
    if end < 1 + count:
        raise FormatError("a meshopt stream of indices is cut off")
    out, last, at = array("I", bytes(4 * count)), [0, 0], 1
    for place in range(count):
        if at >= end:
            raise FormatError("a meshopt stream of indices is cut off")
        value, at = _number(data, at)
        line, value = value & 1, value >> 1
        last[line] = (last[line] + (value >> 1 ^ -(value & 1))) & _MASK
        out[place] = last[line]
    if at != end:
        raise FormatError("a meshopt stream of indices is longer than its indices")
    return np.frombuffer(out, np.uint32)

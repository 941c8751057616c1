"""Numbers in spans of a text, rounded as `float` rounds them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.text.short_numbers import ByteArray, read_short_floats, read_short_ints
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "ByteArray",
    "compact",
    "line_number",
    "needs_finite",
    "parse_floats",
    "parse_ints",
    "readable",
    "span_mask",
]

_BLANK = 32
# Spans are read this many at a time: few enough to stay in the cache.
_BATCH = 1 << 16
# What the C library of Windows wrote for infinity and for what is not a number.
_WINDOWS = re.compile(rb"(?<![^ ])([-+]?)1\.#(INF|IND|QNAN|SNAN)0*(?= )")


def readable(text: ByteArray, start: int, end: int) -> str:
    """Return a word of the text for a message: shortened, and printable whatever its bytes are."""
    word = text[start : min(end, start + 40)].tobytes().decode("latin-1")
    return word if word.isascii() and word.isprintable() else ascii(word)[1:-1]


def line_number(text: ByteArray, offset: int) -> int:
    """Return the number, from 1, of the line that byte `offset` of a text stands on."""
    head = text[:offset].tobytes()
    return 1 + head.count(b"\n") + head.count(b"\r") - head.count(b"\r\n")


def span_mask(size: int, starts: IntArray, ends: IntArray) -> NDArray[np.bool_]:
    """Return (size,) True inside the spans [start, end), which may touch but not overlap."""
    steps = np.zeros(size + 1, dtype=np.int8)
    steps[starts] += 1
    steps[ends] -= 1
    return np.cumsum(steps[:-1], dtype=np.int8).view(np.bool_)


def compact(text: ByteArray, starts: IntArray, ends: IntArray) -> ByteArray:
    """Return the bytes of the spans, which ascend and are not empty, each followed by one space."""
    if not len(starts):
        return np.empty(0, dtype=np.uint8)
    low, high = int(starts[0]), int(ends[-1]) + 1
    region = text[low:high] if high <= len(text) else np.append(text[low:high], np.uint8(_BLANK))
    packed = region[span_mask(high - low, starts - low, ends + 1 - low)]
    packed[np.cumsum(ends - starts + 1) - 1] = _BLANK
    return packed


def parse_floats(text: ByteArray, starts: IntArray, ends: IntArray, finite: bool = True) -> FloatArray:
    """Return the (k,) numbers in the spans, ascending, each rounded correctly as `float` does.

    Raises `FormatError` with the line of the first span that is not a number, finite if so asked.
    """
    values: FloatArray = _parse(text, starts, ends, np.float64, "a number")
    bad = ~np.isfinite(values)
    if finite and bad.any():
        raise FormatError(needs_finite(text, int(starts[np.argmax(bad)]), int(ends[np.argmax(bad)])))
    return values


def needs_finite(text: ByteArray, start: int, end: int) -> str:
    """Return the sentence that refuses a number for not being finite."""
    where = line_number(text, start)
    return f"line {where} has '{readable(text, start, end)}' where a finite number is expected"


def parse_ints(text: ByteArray, starts: IntArray, ends: IntArray) -> IntArray:
    """Return the (k,) whole numbers in the spans, ascending; numbers beyond 64 bits
    give one at the end of their range.

    Raises `FormatError` with the line of the first span that is not a whole number.
    """
    return _parse(text, starts, ends, np.int64, "a whole number")


def _parse(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any, wanted: str) -> NDArray[Any]:
    values = np.empty(len(starts), dtype=dtype)
    read_short: Any = read_short_floats if dtype is np.float64 else read_short_ints
    for low in range(0, len(starts), _BATCH):
        batch = slice(low, low + _BATCH)
        values[batch], good = read_short(text, starts[batch], ends[batch])
        if good.all():
            continue
        rest = np.flatnonzero(~good) + low
        found = _read(text, starts[rest], ends[rest], dtype)
        if found is None:
            start, end = _first_bad(text, starts[rest], ends[rest], dtype)
            word = readable(text, start, end)
            raise FormatError(f"line {line_number(text, start)} has '{word}' where {wanted} is expected")
        values[rest] = found
    return values


def _read(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any) -> NDArray[Any] | None:
    if (ends <= starts).any():
        return None
    words = compact(text, starts, ends).tobytes()
    if b"#" in words:
        words = _WINDOWS.sub(lambda found: found[1] + (b"inf" if found[2] == b"INF" else b"nan"), words)
    try:
        values = np.fromstring(words, dtype=dtype, sep=" ")
    except ValueError:
        return None
    return values if len(values) == len(starts) else None


def _first_bad(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any) -> tuple[int, int]:
    low, high = 0, len(starts)
    while high - low > 1:
        middle = (low + high) // 2
        if _read(text, starts[low:middle], ends[low:middle], dtype) is None:
            high = middle
        else:
            low = middle
    return int(starts[low]), int(ends[low])

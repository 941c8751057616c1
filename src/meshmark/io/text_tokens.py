"""Text files as arrays: where the tokens are, and the numbers in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "ByteArray",
    "Tokens",
    "compact",
    "line_number",
    "parse_floats",
    "parse_ints",
    "span_mask",
    "tokenise",
]

ByteArray = NDArray[np.uint8]

_SPACE = np.zeros(256, dtype=bool)
_SPACE[[9, 10, 11, 12, 13, 32]] = True
_BLANK, _HASH, _BACKSLASH, _LF, _CR = 32, 35, 92, 10, 13

_UTF16 = (b"\xff\xfe", b"\xfe\xff")
_UTF8 = b"\xef\xbb\xbf"


@dataclass(frozen=True, eq=False)
class Tokens:
    """Where the words of a text stand.

    text:   (size + 1,) bytes; comments are blanked, and one space is added at the end.
    starts: (k,) offsets of the first byte of each token; ends: one past its last byte.
    first:  (l,) index of the first token of each line that has any.
    """

    text: ByteArray
    starts: IntArray
    ends: IntArray
    first: IntArray

    def word(self, index: int) -> str:
        """Return token `index` as text, shortened for a message."""
        return _readable(self.text, int(self.starts[index]), int(self.ends[index]))

    def line(self, index: int) -> int:
        """Return the number, from 1, of the line that token `index` stands on."""
        return line_number(self.text, int(self.starts[index]))

    def equal(self, chosen: IntArray, word: bytes, fold: bool = True) -> NDArray[np.bool_]:
        """Return (k,) which of the chosen tokens are `word`, which is lower case; fold: in any case."""
        starts = self.starts[chosen]
        same = self.ends[chosen] - starts == len(word)
        for place, letter in enumerate(word):
            # A short word at the end of the text must not run over.
            letters = self.text[np.minimum(starts + place, len(self.text) - 1)]
            same &= (letters | 0x20 if fold else letters) == letter
        return same

    def counts(self) -> IntArray:
        """Return the (l,) number of tokens on each line that has any."""
        return np.diff(self.first, append=len(self.starts))


def _readable(text: ByteArray, start: int, end: int) -> str:
    word = text[start : min(end, start + 40)].tobytes().decode("latin-1")
    return word if word.isascii() and word.isprintable() else ascii(word)[1:-1]


def line_number(text: ByteArray, offset: int) -> int:
    """Return the number, from 1, of the line that byte `offset` of a text stands on."""
    head = text[:offset].tobytes()
    return 1 + head.count(b"\n") + head.count(b"\r") - head.count(b"\r\n")


def tokenise(data: bytes, offset: int = 0, comments: bool = False, continued: bool = False) -> Tokens:
    """Split the text from byte `offset` on at white space; `\\n`, `\\r\\n` and `\\r` all end a line.

    comments: `#` hides the rest of its line. continued: a backslash at the end of a line joins the next.
    Raises `FormatError` for UTF-16 and for text with zero bytes.
    """
    if data.startswith(_UTF16):
        raise FormatError("the file is UTF-16 text, expected ASCII or UTF-8")
    if data.find(b"\0", offset) >= 0:
        raise FormatError("the file has zero bytes where text is expected")
    text = np.frombuffer(data + b" ", dtype=np.uint8).copy()
    text[:offset] = np.where(_line_breaks(text[:offset]), text[:offset], _BLANK)
    if data.startswith(_UTF8):
        text[:3] = _BLANK
    if comments and data.find(b"#", offset) >= 0:
        _blank_comments(text)
    joined = _join_lines(text) if continued and b"\\" in data else text
    space = _SPACE[joined].view(np.int8)
    steps = np.diff(space, prepend=np.int8(1))
    starts, ends = np.flatnonzero(steps == -1), np.flatnonzero(steps == 1)
    breaks = np.searchsorted(starts, np.flatnonzero(_line_breaks(joined)))
    first = np.concatenate([[0], breaks])
    first = first[np.diff(first, append=len(starts)) > 0]
    return Tokens(text, starts, ends, first)


def _line_breaks(text: ByteArray) -> NDArray[np.bool_]:
    return (text == _LF) | (text == _CR)


def _blank_comments(text: ByteArray) -> None:
    marks = np.flatnonzero(text == _HASH)
    breaks = np.append(np.flatnonzero(_line_breaks(text)), len(text))
    stops = breaks[np.searchsorted(breaks, marks)]
    leading = np.diff(stops, prepend=-1) > 0
    text[span_mask(len(text), marks[leading], stops[leading])] = _BLANK


def _join_lines(text: ByteArray) -> ByteArray:
    joined = text.copy()
    slashes = np.flatnonzero(text[:-1] == _BACKSLASH)
    slashes = slashes[_line_breaks(text[slashes + 1])]
    joined[slashes] = joined[slashes + 1] = _BLANK
    paired = slashes[(text[slashes + 1] == _CR) & (text[np.minimum(slashes + 2, len(text) - 1)] == _LF)]
    joined[paired + 2] = _BLANK
    return joined


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
    inside = span_mask(high - low, starts - low, ends + 1 - low)
    packed = text[low:high][inside]
    packed[np.cumsum(ends - starts + 1) - 1] = _BLANK
    return packed


def parse_floats(tokens: Tokens, chosen: IntArray, finite: bool = True) -> FloatArray:
    """Return the (k,) numbers of the chosen tokens, ascending, each rounded correctly as `float` does.

    Raises `FormatError` with the line of the first token that is not a number, finite if so asked.
    """
    starts, ends = tokens.starts[chosen], tokens.ends[chosen]
    values = _parse(tokens.text, starts, ends, np.float64, "a number")
    bad = ~np.isfinite(values)
    if finite and bad.any():
        index = int(chosen[np.argmax(bad)])
        raise FormatError(
            f"line {tokens.line(index)} has '{tokens.word(index)}' where a finite number is expected"
        )
    return values


def parse_ints(text: ByteArray, starts: IntArray, ends: IntArray) -> IntArray:
    """Return the (k,) whole numbers in the spans, ascending; numbers beyond 64 bits saturate.

    Raises `FormatError` with the line of the first span that is not a whole number.
    """
    return _parse(text, starts, ends, np.int64, "a whole number")


def _parse(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any, wanted: str) -> NDArray[Any]:
    values = _read(text, starts, ends, dtype)
    if values is None:
        offset, end = _first_bad(text, starts, ends, dtype)
        word = _readable(text, offset, end)
        raise FormatError(f"line {line_number(text, offset)} has '{word}' where {wanted} is expected")
    return values


def _read(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any) -> NDArray[Any] | None:
    if not len(starts):
        return np.empty(0, dtype=dtype)
    if (ends <= starts).any():
        return None
    try:
        values = np.fromstring(compact(text, starts, ends).tobytes(), dtype=dtype, sep=" ")
    except ValueError:
        return None
    return values if len(values) == len(starts) else None


def _first_bad(text: ByteArray, starts: IntArray, ends: IntArray, dtype: Any) -> tuple[int, int]:
    # Halving finds the first bad span in a file of any size.
    low, high = 0, len(starts)
    while high - low > 1:
        middle = (low + high) // 2
        if _read(text, starts[low:middle], ends[low:middle], dtype) is None:
            high = middle
        else:
            low = middle
    return int(starts[low]), int(ends[low])

"""Text files as arrays: where the words stand, block by block so that the work stays in the cache."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.text.numbers import ByteArray, line_number, readable, span_mask
from meshmark.mesh import IntArray

__all__ = ["Tokens", "key", "token_blocks", "tokenise"]

_SPACE = np.zeros(256, dtype=bool)
_SPACE[[9, 10, 11, 12, 13, 32]] = True
_DOT, _ONE, _I_Q_S = 46, 49, np.frombuffer(b"IQS", dtype=np.uint8)
_BLANK, _HASH, _BACKSLASH, _LF, _CR = 32, 35, 92, 10, 13

_UTF16 = (b"\xff\xfe", b"\xfe\xff")
_UTF8 = b"\xef\xbb\xbf"

_BLOCK = 1 << 20
# Words of up to eight letters are compared as one 64-bit number.
_LETTERS = 8
_LOW_BYTES = np.array([(1 << 8 * k) - 1 for k in range(_LETTERS + 1)], dtype=np.uint64)
_LOWER_CASE = np.uint64(0x2020202020202020)


@dataclass(frozen=True, eq=False, kw_only=True)
class Tokens:
    """Where the words of a text, or of a block of it, stand.

    text:   the bytes. A block has comments blanked and eight spaces behind it.
    starts: (k,) offsets of the first byte of each token; ends: one past its last byte.
    first:  (l,) index of the first token of each line that has any.
    """

    text: ByteArray
    starts: IntArray
    ends: IntArray
    first: IntArray

    @property
    def closed(self) -> bool:
        """Whether anything follows the last token, so that it is not cut short."""
        return bool(len(self.ends)) and int(self.ends[-1]) < len(self.text)

    def word(self, index: int) -> str:
        """Return token `index` as text, shortened for a message."""
        return readable(self.text, int(self.starts[index]), int(self.ends[index]))

    def line(self, index: int) -> int:
        """Return the number, from 1, of the line that token `index` stands on."""
        return line_number(self.text, int(self.starts[index]))

    def counts(self) -> IntArray:
        """Return the (l,) number of tokens on each line that has any."""
        return np.diff(self.first, append=len(self.starts))

    def keys(self, chosen: IntArray, fold: bool = False) -> NDArray[np.uint64]:
        """Return (k,) numbers that tell the chosen tokens apart by their first eight letters; see `key`.

        Tokens of more letters have key 0. fold: upper case counts as lower case.
        """
        starts, lengths = self.starts[chosen], (self.ends - self.starts)[chosen]
        text = self.text
        if len(text) < _LETTERS or (len(starts) and starts[-1] + _LETTERS > len(text)):
            text = np.append(text, np.full(_LETTERS, _BLANK, dtype=np.uint8))
        windows: NDArray[np.uint64] = np.ndarray((len(text) - _LETTERS + 1,), "<u8", text.data, 0, (1,))
        keys = windows[starts] | _LOWER_CASE if fold else windows[starts]
        return np.where(lengths <= _LETTERS, keys & _LOW_BYTES[np.minimum(lengths, _LETTERS)], np.uint64(0))


def key(word: bytes) -> np.uint64:
    """Return the number that `Tokens.keys` gives for a word of up to eight letters."""
    return np.uint64(int.from_bytes(word, "little"))


def tokenise(data: bytes, offset: int = 0, comments: bool = False) -> Tokens:
    """Split the text from byte `offset` on at white space; see `token_blocks`."""
    starts, ends, first, count = [], [], [], 0
    for base, block in token_blocks(data, offset, comments):
        starts.append(block.starts + base)
        ends.append(block.ends + base)
        first.append(block.first + count)
        count += len(block.starts)
    text = np.frombuffer(data, dtype=np.uint8)
    empty = [np.empty(0, dtype=np.int64)]
    return Tokens(
        text=text,
        starts=np.concatenate(starts or empty),
        ends=np.concatenate(ends or empty),
        first=np.concatenate(first or empty),
    )


def token_blocks(
    data: bytes, offset: int = 0, comments: bool = False, continued: bool = False
) -> Iterator[tuple[int, Tokens]]:
    """Yield blocks of whole lines, each with its offset; `\\n`, `\\r\\n` and `\\r` all end a line.

    comments: `#` hides the rest of its line. continued: a backslash at the end of a line joins the next.
    Raises `FormatError` for UTF-16 and for text with zero bytes.
    """
    if data.startswith(_UTF16):
        raise FormatError("the file is UTF-16 text, expected ASCII or UTF-8")
    if data.find(b"\0", offset) >= 0:
        raise FormatError("the file has zero bytes where text is expected")
    if offset == 0 and data.startswith(_UTF8):
        offset = len(_UTF8)
    comments, continued = comments and b"#" in data, continued and b"\\" in data
    while offset < len(data):
        end = _block_end(data, offset, continued)
        text = np.frombuffer(data[offset:end] + b" " * _LETTERS, dtype=np.uint8)
        yield offset, _block(text, comments, continued)
        offset = end


def _block_end(data: bytes, offset: int, continued: bool) -> int:
    for reach in range(offset + _BLOCK, len(data), _BLOCK):
        last = data.rfind(b"\n", offset, reach)
        last = last if last >= 0 else data.rfind(b"\r", offset, reach)
        if last >= 0:
            end = last + (2 if data[last : last + 2] == b"\r\n" else 1)
            if not (continued and data[offset:end].endswith((b"\\\n", b"\\\r", b"\\\r\n"))):
                return end
    return len(data)


def _block(text: ByteArray, comments: bool, continued: bool) -> Tokens:
    if comments or continued:
        text = text.copy()
    if comments:
        _blank_comments(text)
    if continued:
        _join_lines(text)
    steps = np.diff(_SPACE[text].view(np.int8), prepend=np.int8(1))
    starts, ends = np.flatnonzero(steps == -1), np.flatnonzero(steps == 1)
    breaks = np.searchsorted(starts, np.flatnonzero(_line_breaks(text)))
    first = np.concatenate([[0], breaks])
    return Tokens(text=text, starts=starts, ends=ends, first=first[np.diff(first, append=len(starts)) > 0])


def _line_breaks(text: ByteArray) -> NDArray[np.bool_]:
    return np.asarray((text == _LF) | (text == _CR))


def _blank_comments(text: ByteArray) -> None:
    marks = np.flatnonzero(text == _HASH)
    # Not those within "1.#IND" and the like, numbers as the C library of Windows wrote them.
    marks = marks[~((text[marks - 1] == _DOT) & (text[marks - 2] == _ONE) & np.isin(text[marks + 1], _I_Q_S))]
    breaks = np.append(np.flatnonzero(_line_breaks(text)), len(text))
    stops = breaks[np.searchsorted(breaks, marks)]
    leading = np.diff(stops, prepend=-1) > 0
    text[span_mask(len(text), marks[leading], stops[leading])] = _BLANK


def _join_lines(text: ByteArray) -> None:
    slashes = np.flatnonzero(text[:-1] == _BACKSLASH)
    slashes = slashes[_line_breaks(text[slashes + 1])]
    # The text ends in spaces, so that two bytes follow every backslash.
    paired = slashes[(text[slashes + 1] == _CR) & (text[slashes + 2] == _LF)]
    text[slashes] = text[slashes + 1] = text[paired + 2] = _BLANK

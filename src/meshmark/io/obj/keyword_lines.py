"""The lines of an OBJ file by keyword, and the indices on its `f` lines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from meshmark.arrays import members
from meshmark.errors import FormatError
from meshmark.io.text.numbers import ByteArray, line_number, parse_ints, readable
from meshmark.io.text.tokens import key, token_blocks
from meshmark.mesh import IntArray

__all__ = ["ObjLines", "Rows", "corner_indices", "obj_lines"]

_SLASH = ord("/")


@dataclass(frozen=True, eq=False, kw_only=True)
class Rows:
    """All lines of one keyword.

    starts, ends: (k,) spans of the words behind the keyword, of all lines, ascending.
    counts:       (l,) words on each line. numbers: (l,) place of each line among all lines of the file.
    heads:        (l,) offset of the keyword.
    """

    text: ByteArray
    starts: IntArray
    ends: IntArray
    counts: IntArray
    numbers: IntArray
    heads: IntArray

    def __len__(self) -> int:
        return len(self.counts)

    def texts(self) -> list[bytes]:
        """Return what stands behind the keyword on each line that has anything there."""
        last = np.cumsum(self.counts)
        there = self.counts > 0
        pairs = zip(self.starts[(last - self.counts)[there]], self.ends[last[there] - 1], strict=True)
        return [self.text[start:end].tobytes() for start, end in pairs]

    def columns(self, first: int, width: int, name: str) -> tuple[IntArray, IntArray]:
        """Return the (l, width) spans of the words `first` to `first + width` of each line.

        Raises `FormatError` where a line has fewer.
        """
        short = self.counts < first + width
        if short.any():
            row = int(np.argmax(short))
            where = line_number(self.text, int(self.heads[row]))
            raise FormatError(
                f"line {where}: '{name}' has {self.counts[row]} numbers, expected {first + width}"
            )
        chosen = (np.cumsum(self.counts) - self.counts + first)[:, None] + np.arange(width)
        return self.starts[chosen], self.ends[chosen]


@dataclass(frozen=True, eq=False)
class ObjLines:
    """An OBJ file: the lines of some keywords, and how many there are of others."""

    rows: dict[bytes, Rows]
    census: dict[bytes, int]


def obj_lines(data: bytes, wanted: Iterable[bytes], counted: Iterable[bytes] = ()) -> ObjLines:
    """Collect the lines of the wanted keywords; a backslash joins a line with the next."""
    text = np.frombuffer(data, dtype=np.uint8)
    parts: dict[bytes, list[tuple[IntArray, ...]]] = {word: [] for word in wanted}
    census = dict.fromkeys(counted, 0)
    lines = 0
    for base, block in token_blocks(data, comments=True, continued=True):
        keys, counts = block.keys(block.first), block.counts() - 1
        for word in census:
            census[word] += int((keys == key(word)).sum())
        for word, found in parts.items():
            rows = np.flatnonzero(keys == key(word))
            group, place = members(counts[rows])
            chosen = block.first[rows][group] + 1 + place
            heads = block.starts[block.first[rows]] + base
            found.append(
                (block.starts[chosen] + base, block.ends[chosen] + base, counts[rows], rows + lines, heads)
            )
        lines += len(block.first)
    empty = (np.empty(0, dtype=np.int64),) * 5
    joined = {}
    for word, found in parts.items():
        starts, ends, words, numbers, heads = (
            np.concatenate(column) for column in zip(*(found or [empty]), strict=True)
        )
        joined[word] = Rows(text=text, starts=starts, ends=ends, counts=words, numbers=numbers, heads=heads)
    return ObjLines(joined, census)


def corner_indices(faces: Rows, field: int, defined: Rows) -> IntArray:
    """Return index `field` (0 position, 1 texture, 2 normal) of every corner of the `f` lines.

    defined: the lines that define what is indexed; negative indices count back from the last one
    before the face. Absent indices give -1.
    Raises `FormatError` for an index that is zero, out of range or not a whole number.
    """
    starts, ends = _field(faces, field)
    there = np.flatnonzero(ends > starts) if field else np.arange(len(starts))
    values = parse_ints(faces.text, starts[there], ends[there])
    wrong = values == 0
    if (values < 0).any():
        before = np.repeat(np.searchsorted(defined.numbers, faces.numbers), faces.counts)[there]
        values += np.where(values < 0, before + 1, 0)
    values -= 1
    wrong |= (values < 0) | (values >= len(defined))
    if wrong.any():
        what = ("vertices", "texture coordinates", "normals")[field]
        raise _refusal(faces, int(there[np.argmax(wrong)]), f"but {len(defined)} {what} are defined")
    if len(there) == len(starts):
        return values
    result = np.full(len(starts), -1, dtype=np.int64)
    result[there] = values
    return result


def _field(faces: Rows, field: int) -> tuple[IntArray, IntArray]:
    """Return the spans of one index in corners of the form 1, 1/2, 1//3 or 1/2/3."""
    starts, ends = faces.starts, faces.ends
    low, high = (int(starts[0]), int(ends[-1])) if len(starts) else (0, 0)
    slashes = np.flatnonzero(faces.text[low:high] == _SLASH) + low
    if not len(slashes):
        return (ends, ends) if field else (starts, ends)
    first = np.searchsorted(slashes, starts)
    slashes = np.append(slashes, np.full(3, len(faces.text)))
    third = slashes[first + 2] < ends
    if third.any():
        raise _refusal(faces, int(np.argmax(third)), "expected up to three indices")
    stops = np.minimum(slashes[first + field], ends)
    begins = starts if field == 0 else np.minimum(slashes[first + field - 1] + 1, ends)
    return begins, stops


def _refusal(faces: Rows, corner: int, why: str) -> FormatError:
    start, end = int(faces.starts[corner]), int(faces.ends[corner])
    word = readable(faces.text, start, end)
    return FormatError(f"line {line_number(faces.text, start)} has the corner '{word}', {why}")

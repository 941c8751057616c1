"""The lines of an OBJ file by keyword, and the indices on its `f` lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.polygons import spread
from meshmark.io.text_tokens import Tokens, parse_ints, tokenise
from meshmark.mesh import IntArray

__all__ = ["ObjLines", "obj_lines"]

_SLASH = ord("/")


@dataclass(frozen=True, eq=False)
class ObjLines:
    """An OBJ file split into lines.

    heads: (l,) first token of each line; counts: (l,) tokens behind it.
    """

    tokens: Tokens
    heads: IntArray
    counts: IntArray

    def keyword(self, word: bytes, fold: bool = False) -> NDArray[np.bool_]:
        """Return (l,) which lines start with `word`; fold: in upper or lower case."""
        return self.tokens.equal(self.heads, word, fold)

    def columns(self, lines: IntArray, width: int, name: str) -> IntArray:
        """Return the (k * width,) tokens of the first `width` numbers on these lines.

        Raises `FormatError` where a line has fewer.
        """
        short = self.counts[lines] < width
        if short.any():
            line = lines[np.argmax(short)]
            where = self.tokens.line(int(self.heads[line]))
            raise FormatError(f"line {where}: '{name}' has {self.counts[line]} numbers, expected {width}")
        return (self.heads[lines][:, None] + 1 + np.arange(width)).ravel()

    def corners(self, lines: IntArray) -> tuple[IntArray, IntArray]:
        """Return the tokens behind the keyword of these lines, and the line (its place) of each."""
        group, place = spread(self.counts[lines])
        return self.heads[lines][group] + 1 + place, group

    def indices(self, field: int, lines: IntArray, defined: IntArray) -> IntArray:
        """Return index `field` (0 position, 1 texture, 2 normal) of every corner of these `f` lines.

        defined: (d,) the lines that define what is indexed, ascending; negative indices count back
        from the last one before the face. Absent indices give -1.
        Raises `FormatError` for an index that is zero, out of range or not a whole number.
        """
        chosen, group = self.corners(lines)
        starts, ends = self._field(field, chosen)
        result = np.full(len(chosen), -1, dtype=np.int64)
        there = ends > starts if field else np.ones(len(chosen), dtype=bool)
        values = parse_ints(self.tokens.text, starts[there], ends[there])
        before = np.searchsorted(defined, lines)[group[there]]
        result[there] = np.where(values > 0, values - 1, values + before)
        wrong = (values == 0) | (result[there] < 0) | (result[there] >= len(defined))
        if wrong.any():
            bad = int(chosen[there][np.argmax(wrong)])
            raise FormatError(
                f"line {self.tokens.line(bad)} has the corner '{self.tokens.word(bad)}', but "
                f"{len(defined)} {('vertices', 'texture coordinates', 'normals')[field]} are defined"
            )
        return result

    def _field(self, field: int, chosen: IntArray) -> tuple[IntArray, IntArray]:
        """Return the spans of one index in corners of the form 1, 1/2, 1//3 or 1/2/3."""
        starts, ends = self.tokens.starts[chosen], self.tokens.ends[chosen]
        slashes = np.flatnonzero(self.tokens.text == _SLASH)
        if not len(slashes):
            return (ends, ends) if field else (starts, ends)
        slashes = np.append(slashes, len(self.tokens.text))
        first = np.searchsorted(slashes, starts)
        cuts = [np.minimum(slashes[np.minimum(first + k, len(slashes) - 1)], ends) for k in range(4)]
        if (cuts[2] < ends).any():
            bad = int(chosen[np.argmax(cuts[2] < ends)])
            raise FormatError(
                f"line {self.tokens.line(bad)} has the corner '{self.tokens.word(bad)}', expected up to 3 indices"
            )
        begin = starts if field == 0 else np.minimum(cuts[field - 1] + 1, ends)
        return begin, cuts[field]


def obj_lines(data: bytes) -> ObjLines:
    """Split an OBJ file into lines; a backslash joins a line with the next, `#` starts a comment."""
    tokens = tokenise(data, comments=True, continued=True)
    return ObjLines(tokens, tokens.first, tokens.counts() - 1)

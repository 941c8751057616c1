"""The coordinates of a text file: read from their tokens, and patched back into them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import members
from meshmark.errors import FormatError, InputError
from meshmark.io.gaps import Gaps
from meshmark.io.text.number_printing import format_numbers, round_numbers
from meshmark.io.text.number_style import NumberStyle, detect_style, digits_needed
from meshmark.io.text.numbers import ByteArray, needs_finite, parse_floats, span_mask
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Edits", "TextPositions", "merge_edits", "splice", "text_positions"]

# Starts and ends of spans to replace, ascending; the new texts joined; their lengths.
Edits = tuple[IntArray, IntArray, ByteArray, IntArray]

# Edits are made this many at a time: few enough to stay in the cache.
_BATCH = 1 << 16


@dataclass(frozen=True, eq=False, kw_only=True)
class TextPositions:
    """Coordinates that stand as tokens in a text.

    data:         the file.
    starts, ends: (3n,) byte spans of the coordinates, row by row, ascending.
    values:       (n, 3) what they say.
    order:        (3,) the axes in the order in which a row has them.
    gaps:         rows of the file that are left out, None where there are none.
    """

    data: bytes
    starts: IntArray
    ends: IntArray
    values: FloatArray
    style: NumberStyle
    order: IntArray
    gaps: Gaps | None = None

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would say for these."""
        return self._rounded(vertices)[0]

    def patch(self, vertices: FloatArray) -> bytes:
        """Return the file with the changed coordinates written in its own number style."""
        return splice(self.data, *self.edits(vertices))

    def edits(self, vertices: FloatArray) -> Edits:
        """Return which spans to replace, and by what."""
        rounded, digits = self._rounded(vertices)
        numbers = rounded[:, self.order].ravel()
        changed = np.flatnonzero(numbers != self.values[:, self.order].ravel())
        letters, lengths = format_numbers(self.style, digits, numbers[changed])
        return self.starts[changed], self.ends[changed], letters, lengths

    def describe(self) -> str:
        """Return the number style in words."""
        return self.style.describe()

    def _rounded(self, vertices: FloatArray) -> tuple[FloatArray, int]:
        if np.shape(vertices) != self.values.shape or not np.isfinite(vertices).all():
            raise InputError(f"new positions must be finite and of shape {self.values.shape}")
        kept = vertices == self.values
        digits = digits_needed(self.style, vertices)
        while True:
            rounded = round_numbers(self.style, digits, np.ravel(vertices)).reshape(vertices.shape)
            rounded = np.where(kept, self.values, rounded)
            # Rounding may move the extent across a power of ten; the file as written decides, so that
            # writing what was read back changes nothing.
            again = digits_needed(self.style, rounded)
            if again >= digits:
                return rounded, digits
            digits = again


def text_positions(
    data: bytes, starts: IntArray, ends: IntArray, whole: bool = False, finite: bool = False
) -> TextPositions:
    """Read the coordinates x, y, z that stand in these spans, (n, 3), row by row ascending.

    Within a row the order may differ, the same in all rows. whole: the file allows whole numbers only.
    finite: refuse every row without finite coordinates; else such rows are left out, as `gaps` says.
    """
    order = np.argsort(starts[0])
    text = np.frombuffer(data, dtype=np.uint8)
    begins, stops = starts[:, order].ravel(), ends[:, order].ravel()
    values = parse_floats(text, begins, stops, finite)
    gaps, good = None, np.asarray(np.isfinite(values).reshape(-1, 3).all(axis=1))
    if not good.all():
        where = partial(_not_finite, text, begins, stops, ~np.isfinite(values))
        gaps = Gaps(kept=np.flatnonzero(good), total=len(good), say=where)
        if not good.any():
            raise FormatError(where(0))
        spans = np.repeat(good, 3)
        begins, stops, values = begins[spans], stops[spans], values[spans]
    style = (
        NumberStyle(kind="whole", significant=1, decimals=0, least=0)
        if whole
        else detect_style(text, begins, stops, values)
    )
    return TextPositions(
        data=data,
        starts=begins,
        ends=stops,
        values=values.reshape(-1, 3)[:, np.argsort(order)],
        style=style,
        order=order,
        gaps=gaps,
    )


def _not_finite(text: ByteArray, begins: IntArray, stops: IntArray, bad: NDArray[np.bool_], row: int) -> str:
    place = 3 * row + int(np.argmax(bad[3 * row : 3 * row + 3]))
    return needs_finite(text, int(begins[place]), int(stops[place]))


def splice(data: bytes, starts: IntArray, ends: IntArray, letters: ByteArray, lengths: IntArray) -> bytes:
    """Return `data` with the spans, ascending, replaced by the texts in `letters` of these lengths."""
    parts, done, used = [], 0, 0
    for low in range(0, len(starts), _BATCH):
        batch = slice(low, low + _BATCH)
        end, grown = int(ends[batch][-1]), int(lengths[batch].sum())
        old = np.frombuffer(data, dtype=np.uint8, count=end - done, offset=done)
        parts.append(
            _spliced(
                old, starts[batch] - done, ends[batch] - done, letters[used : used + grown], lengths[batch]
            )
        )
        done, used = end, used + grown
    return b"".join([*parts, data[done:]]) if parts else data


def _spliced(
    old: ByteArray, starts: IntArray, ends: IntArray, letters: ByteArray, lengths: IntArray
) -> bytes:
    growth = lengths - (ends - starts)
    begins = starts + np.cumsum(growth) - growth
    out = np.empty(len(old) + int(growth.sum()), dtype=np.uint8)
    fresh = span_mask(len(out), begins, begins + lengths)
    out[fresh] = letters
    out[~fresh] = old[~span_mask(len(old), starts, ends)]
    return out.tobytes()


def merge_edits(first: Edits, second: Edits) -> Edits:
    """Return two sets of edits as one, ascending."""
    starts, ends = np.concatenate([first[0], second[0]]), np.concatenate([first[1], second[1]])
    letters, lengths = np.concatenate([first[2], second[2]]), np.concatenate([first[3], second[3]])
    order = np.argsort(starts, kind="stable")
    begins = np.cumsum(lengths) - lengths
    group, place = members(lengths[order])
    return starts[order], ends[order], letters[begins[order][group] + place], lengths[order]

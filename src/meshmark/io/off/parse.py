"""OFF and its variants with normals, colours and texture coordinates, as Geomview defines them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from itertools import takewhile
from pathlib import Path

import numpy as np

from meshmark.arrays import members
from meshmark.document import Attributes
from meshmark.errors import FormatError
from meshmark.io.colors import ODD_COLORS, rgba
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.polygons import fan_corners
from meshmark.io.text.numbers import parse_floats, parse_ints
from meshmark.io.text.positions import text_positions
from meshmark.io.text.tokens import Tokens, tokenise
from meshmark.io.wording import amount, surplus
from meshmark.mesh import FloatArray, IntArray

__all__ = ["parse_off"]

# [ST][C][N][4][n]OFF; all lower case is seen too. Some writers put the first count right behind it.
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")
_MAGIC = re.compile(r"(ST)?(C)?(N)?(4)?(n)?OFF(\d*)$")


@dataclass(frozen=True, eq=False, kw_only=True)
class _Layout:
    """Where things stand in an OFF file: token indices."""

    magic: str
    vertices: int
    faces: int
    first_vertex: int
    per_vertex: int
    normals: bool
    colors: int
    texcoords: bool

    @property
    def first_face(self) -> int:
        return self.first_vertex + self.vertices * self.per_vertex

    def column(self, place: int, width: int) -> IntArray:
        """Return the (n * width,) tokens of the numbers `place` to `place + width` of each vertex."""
        rows = self.first_vertex + self.per_vertex * np.arange(self.vertices)
        return (rows[:, None] + place + np.arange(width)).ravel()


def parse_off(data: bytes, _path: Path) -> PatchDocument:
    """Read an OFF file. Raises `FormatError` where it breaks the format."""
    tokens = tokenise(data, comments=True)
    layout = _layout(tokens)
    chosen = layout.column(0, 3).reshape(-1, 3)
    positions = text_positions(data, tokens.starts[chosen], tokens.ends[chosen])
    corners, sizes, colored, left = _faces(tokens, layout)
    remarks = (surplus(left, "word", "words"),) if left else ()
    if len(sizes) < layout.faces:
        remarks = (f"the header declares {amount(layout.faces, 'face', 'faces')}, {len(sizes):,} are there",)
    faces = corners[fan_corners(sizes)]
    polygons = bool((sizes > 3).any())
    facts = {"encoding": "text", "variant": layout.magic, "polygons": polygons, "face_colors": colored}
    load = partial(_attributes, data, polygons, colored)
    return patch_document("off", positions, faces, load, facts=facts, remarks=remarks, gaps=positions.gaps)


def _layout(tokens: Tokens) -> _Layout:
    magic, first = _magic(tokens)
    counts, first = _counts(tokens, first)
    if counts[0] <= 0:
        raise FormatError(f"the header declares {counts[0]} vertices, expected at least 1")
    if counts[1] <= 0:
        raise FormatError(
            f"the header declares {counts[1]} faces, expected a surface (point clouds carry no mark)"
        )
    normals, texcoords = "N" in magic, magic.startswith("ST")
    fixed = 3 + 3 * normals + 2 * texcoords
    colors = 0
    if "C" in magic:
        # Geomview wants four numbers; three are common. The first vertex's line tells.
        line = int(np.searchsorted(tokens.first, first, side="right")) - 1
        colors = int(tokens.counts()[line]) - fixed if line >= 0 else 4
        colors = colors if colors in (3, 4) and tokens.first[line] == first else 4
    per_vertex = fixed + colors
    left = len(tokens.starts) - first
    if counts[0] * per_vertex + counts[1] > left:
        raise FormatError(
            f"the header declares {counts[0]} vertices and {counts[1]} faces, but only {left} numbers follow"
        )
    return _Layout(
        magic=magic,
        vertices=counts[0],
        faces=counts[1],
        first_vertex=first,
        per_vertex=per_vertex,
        normals=normals,
        colors=colors,
        texcoords=texcoords,
    )


def _magic(tokens: Tokens) -> tuple[str, int]:
    word = tokens.word(0) if len(tokens.starts) else ""
    found = _MAGIC.match(word.upper() if word.islower() else word)
    if found is None:
        raise FormatError(f"the file starts with '{word}', expected OFF, COFF, NOFF or another OFF header")
    if found[4] or found[5]:
        raise FormatError(f"the header is {word}, but only points in three dimensions can be read")
    if len(tokens.starts) > 1 and tokens.word(1).upper() == "BINARY":
        raise FormatError("the file is binary OFF, expected OFF as text")
    glued = len(found[6])
    if glued:
        tokens.starts[0] += len(word) - glued
    name = found[0][: len(found[0]) - glued]
    return name, 0 if glued else 1


def _counts(tokens: Tokens, first: int) -> tuple[list[int], int]:
    """Return the numbers of vertices and faces, and the token after them; the edge count may be missing."""
    line = int(np.searchsorted(tokens.first, first, side="right")) - 1
    end = int(np.append(tokens.first, len(tokens.starts))[line + 1]) if len(tokens.starts) > first else first
    if end - first < 2:
        raise FormatError("the header has no counts of vertices and faces, expected two or three numbers")
    # With everything on one line, the third number is the edge count.
    end = min(end, first + 3)
    counts = parse_ints(tokens.text, tokens.starts[first:end], tokens.ends[first:end])
    return [int(count) for count in counts[:2]], end


def _faces(tokens: Tokens, layout: _Layout) -> tuple[IntArray, IntArray, bool, int]:
    """Return the flat corners, the corners per face, whether faces have colours, and the words that follow them."""
    begin = layout.first_face
    line = int(np.searchsorted(tokens.first, begin))
    lines, end = tokens.first[line : line + layout.faces], len(tokens.starts)
    if len(lines) == layout.faces and lines[0] == begin:
        end = int(np.append(tokens.first, end)[line + layout.faces])
        heads, room = lines, np.diff(lines, append=end) - 1
        # A line may hold several faces: then these are not their heads.
        if end < len(tokens.starts) and not _fits(tokens, heads, room):
            heads, room, end = _stream(tokens, layout)
    else:
        try:
            heads, room, end = _stream(tokens, layout)
        except FormatError:
            heads, room = lines, np.diff(lines, append=end) - 1
            fewer = 0 < len(lines) < layout.faces and lines[0] == begin and tokens.closed
            if not fewer or not _fits(tokens, heads, room):
                raise
    sizes = parse_ints(tokens.text, tokens.starts[heads], tokens.ends[heads])
    bad = (sizes < 1) | (sizes > room)
    if bad.any():
        row = int(np.argmax(bad))
        raise FormatError(
            f"line {tokens.line(int(heads[row]))}: face {row} declares {sizes[row]} corners, "
            f"but {room[row]} numbers follow"
        )
    if end < len(tokens.starts) and (sizes < 3).any():
        raise FormatError(
            f"line {tokens.line(end)}: more follows the {layout.faces} faces declared, and among these are "
            "some of fewer than 3 corners, which may be vertices that the header does not count"
        )
    group, place = members(sizes)
    chosen = heads[group] + 1 + place
    corners = parse_ints(tokens.text, tokens.starts[chosen], tokens.ends[chosen])
    wrong = (corners < 0) | (corners >= layout.vertices)
    if wrong.any():
        where, bad = int(np.argmax(wrong)), corners[np.argmax(wrong)]
        raise FormatError(
            f"line {tokens.line(int(chosen[where]))}: face {group[where]} refers to vertex {bad}, "
            f"expected 0 to {layout.vertices - 1}"
        )
    return corners, sizes, bool((room > sizes).any()), len(tokens.starts) - end


def _fits(tokens: Tokens, heads: IntArray, room: IntArray) -> bool:
    """Return whether each of these tokens says how many corners follow it on its line, colours aside."""
    try:
        sizes = parse_ints(tokens.text, tokens.starts[heads], tokens.ends[heads])
    except FormatError:
        return False
    return bool(((sizes >= 1) & (room >= sizes) & (room <= sizes + 4)).all())


def _whole_numbers(tokens: Tokens, begin: int) -> tuple[list[int], FormatError | None]:
    """Return the whole numbers from a token on, up to the first that is none, and the refusal of that one."""
    try:
        return parse_ints(tokens.text, tokens.starts[begin:], tokens.ends[begin:]).tolist(), None
    except FormatError as error:
        words = map(tokens.word, range(begin, len(tokens.starts)))
        return [int(word) for word in takewhile(_WHOLE.fullmatch, words)], error


def _stream(tokens: Tokens, layout: _Layout) -> tuple[IntArray, IntArray, int]:
    """Return first token and corners of each face where faces do not have a line each, and the token after them."""
    begin, total = layout.first_face, len(tokens.starts)
    numbers, broken = _whole_numbers(tokens, begin)
    heads, place = [], 0
    for row in range(layout.faces):
        if place >= len(numbers) or not 0 < numbers[place] < len(numbers) - place:
            where = f"line {tokens.line(min(begin + place, total - 1))}"
            raise broken or FormatError(f"{where}: face {row} of {layout.faces} is not complete")
        heads.append(place)
        place += numbers[place] + 1
    starts = np.array(heads, dtype=np.int64)
    return starts + begin, np.diff(starts, append=place) - 1, begin + place


def _attributes(data: bytes, polygons: bool, colored: bool) -> Attributes:
    tokens = tokenise(data, comments=True)
    layout = _layout(tokens)

    def numbers(place: int, width: int) -> FloatArray:
        chosen = layout.column(place, width)
        spans = tokens.starts[chosen], tokens.ends[chosen]
        return parse_floats(tokens.text, *spans, finite=False).reshape(-1, width)

    after_normals = 3 + 3 * layout.normals
    other = ["polygons"] * polygons + ["face colours"] * colored
    shades = numbers(after_normals, layout.colors) if layout.colors else None
    if shades is not None and not np.isfinite(shades).all():
        shades, other = None, [*other, ODD_COLORS]
    return Attributes(
        normals=numbers(3, 3) if layout.normals else None,
        texcoords=numbers(after_normals + layout.colors, 2) if layout.texcoords else None,
        colors=None if shades is None else rgba(shades),
        other=tuple(other),
    )

"""STL as text: solids of facets, 21 words each."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial

import numpy as np

from meshmark.document import Attributes
from meshmark.errors import FormatError
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.stl.normals import facet_normals, stale_facets
from meshmark.io.text.number_printing import format_numbers, round_numbers
from meshmark.io.text.number_style import NumberStyle, detect_style, digits_needed
from meshmark.io.text.numbers import parse_floats
from meshmark.io.text.positions import Edits, TextPositions, merge_edits, splice, text_positions
from meshmark.io.text.tokens import Tokens, key, tokenise
from meshmark.mesh import FloatArray, IntArray

__all__ = ["parse_text_stl"]

_WORDS = {0: b"facet", 1: b"normal", 5: b"outer", 6: b"loop", 7: b"vertex", 11: b"vertex", 15: b"vertex"}
_WORDS |= {19: b"endloop", 20: b"endfacet"}
_FACET = 21
_SPLIT = re.compile(rb"\bend[ \t]+(loop|facet|solid)\b", re.IGNORECASE)
_NORMAL, _CORNERS = np.array([2, 3, 4]), np.array([8, 9, 10, 12, 13, 14, 16, 17, 18])
# Normals are unit vectors; the usual six decimals are enough for new ones.
_UNIT_BOX, _NORMAL_RESOLUTION = np.array([[-1.0, -1, -1], [1, 1, 1]]), 1e-6


@dataclass(frozen=True, eq=False, kw_only=True)
class _Positions:
    """Corner coordinates and facet normals, each in its own number style."""

    corners: TextPositions
    normals: FloatArray
    starts: IntArray
    ends: IntArray
    style: NumberStyle

    @property
    def values(self) -> FloatArray:
        return self.corners.values

    def conform(self, vertices: FloatArray) -> FloatArray:
        return self.corners.conform(vertices)

    def describe(self) -> str:
        return self.corners.describe()

    def patch(self, vertices: FloatArray) -> bytes:
        after = self.conform(vertices).reshape(-1, 3, 3)
        stale = stale_facets(self.normals, self.values.reshape(-1, 3, 3), after)
        digits = digits_needed(self.style, _UNIT_BOX, _NORMAL_RESOLUTION)
        numbers = round_numbers(self.style, digits, facet_normals(after[stale]).ravel())
        spans = np.repeat(stale, 3)
        turned: Edits = (self.starts[spans], self.ends[spans], *format_numbers(self.style, digits, numbers))
        return splice(self.corners.data, *merge_edits(self.corners.edits(vertices), turned))


def parse_text_stl(data: bytes) -> PatchDocument:
    """Read an STL file of text. Raises `FormatError` where it breaks the format."""
    # Some write "end loop": read as one word, which ends where the two end.
    words = _SPLIT.sub(lambda found: (b"end" + found[1]).rjust(len(found[0])), data)
    tokens = tokenise(words, comments=True)
    rows, solids, remarks = _facets(tokens)
    numbers, chosen = rows[:, _CORNERS].reshape(-1, 3), rows[:, _NORMAL].ravel()
    corners = text_positions(data, tokens.starts[numbers], tokens.ends[numbers], finite=True)
    starts, ends = tokens.starts[chosen], tokens.ends[chosen]
    normals = parse_floats(tokens.text, starts, ends, finite=False)
    plain = np.isfinite(normals)
    style = (
        detect_style(tokens.text, starts[plain], ends[plain], normals[plain])
        if plain.any()
        else corners.style
    )
    positions = _Positions(
        corners=corners, normals=normals.reshape(-1, 3), starts=starts, ends=ends, style=style
    )
    faces = np.arange(3 * len(rows)).reshape(-1, 3)
    facts = {"encoding": "text", "solids": solids}
    return patch_document("stl", positions, faces, partial(_attributes, solids), facts=facts, remarks=remarks)


def _facets(tokens: Tokens) -> tuple[IntArray, int, tuple[str, ...]]:
    """Return the (m, 21) tokens of the facets, the number of solids, and what the user should know of that."""
    lines = tokens.keys(tokens.first, fold=True)
    solid, end = lines == key(b"solid"), lines == key(b"endsolid")
    # Text before the first solid is no part of it, unless facets stand there.
    before = np.arange(len(lines)) < int(np.argmax(solid))
    before &= not np.isin(lines[before], [key(b"facet"), key(b"vertex")]).any()
    words = np.flatnonzero(~np.repeat(solid | end | before, tokens.counts()))
    remarks = () if len(end) and end[-1] else ("the file ends without a line 'endsolid'",)
    if not len(words):
        raise FormatError("the file has no facets, expected a surface")
    whole = len(words) // _FACET * _FACET
    rows = words[:whole].reshape(-1, _FACET)
    wrong = np.zeros(rows.shape, dtype=bool)
    for place, word in _WORDS.items():
        wrong[:, place] = tokens.keys(rows[:, place], fold=True) != key(word)
    if wrong.any():
        token = int(rows.flat[np.argmax(wrong)])
        wanted = _WORDS[int(np.argmax(wrong)) % _FACET].decode()
        raise FormatError(
            f"line {tokens.line(token)} has '{tokens.word(token)}' where '{wanted}' is expected, "
            "or the facet there is not complete"
        )
    if whole < len(words):
        raise FormatError(f"the facet that begins on line {tokens.line(int(words[whole]))} is not complete")
    return rows, int(solid.sum()), remarks


def _attributes(solids: int) -> Attributes:
    return Attributes(other=("solids",) if solids > 1 else ())

"""What an OBJ file holds beside positions and faces, for a conversion to another format."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.colors import rgba
from meshmark.io.document import Attributes
from meshmark.io.obj_lines import ObjLines, obj_lines
from meshmark.io.polygons import fan_corners
from meshmark.io.text_tokens import parse_floats
from meshmark.mesh import FloatArray, IntArray

__all__ = ["obj_attributes"]

# Keywords whose lines no other format can keep, and the name that a report gives them.
_ELSEWHERE = {
    b"o": "objects",
    b"g": "groups",
    b"s": "smoothing groups",
    b"usemtl": "materials",
    b"mtllib": "materials",
    b"l": "lines",
    b"p": "points",
    b"curv": "curves and surfaces",
    b"curv2": "curves and surfaces",
    b"surf": "curves and surfaces",
}


def obj_attributes(data: bytes) -> Attributes:
    """Return normals, texture coordinates and colours of an OBJ file.

    Where corners of one vertex differ (texture seams), the arrays are per distinct corner, with `seams`.
    Raises `FormatError` for numbers or indices that cannot be read.
    """
    lines = obj_lines(data)
    points, polygons = np.flatnonzero(lines.keyword(b"v")), np.flatnonzero(lines.keyword(b"f"))
    sizes = lines.counts[polygons]
    other = [name for word, name in _ELSEWHERE.items() if lines.keyword(word).any()]
    other += ["polygons"] * bool((sizes > 3).any())
    corners = np.empty((int(sizes.sum()), 3), dtype=np.int64)
    corners[:, 0] = lines.indices(0, polygons, points)
    tables = []
    for field, (word, width, name) in enumerate(
        ((b"vt", 2, "texture coordinates"), (b"vn", 3, "normals")), 1
    ):
        defined = np.flatnonzero(lines.keyword(word))
        corners[:, field] = lines.indices(field, polygons, defined)
        table = _table(lines, defined, width, word.decode())
        if table is not None and (corners[:, field] < 0).any():
            other += [f"{name} of some faces"] if (corners[:, field] >= 0).any() else [f"unused {name}"]
            table = None
        if table is None:
            corners[:, field] = -1
        tables.append(table)
    colors = _colors(lines, points)
    other += ["vertex colours of some vertices"] * bool(colors is None and (lines.counts[points] >= 6).any())
    return _aligned(corners, fan_corners(sizes), len(points), tables, colors, tuple(dict.fromkeys(other)))


def _table(lines: ObjLines, defined: IntArray, width: int, name: str) -> FloatArray | None:
    if not len(defined):
        return None
    # A texture coordinate may have one number only: its second is zero.
    if width == 2 and (lines.counts[defined] == 1).all():
        first = parse_floats(lines.tokens, lines.columns(defined, 1, name))
        return np.stack([first, np.zeros_like(first)], axis=1)
    return parse_floats(lines.tokens, lines.columns(defined, width, name)).reshape(-1, width)


def _colors(lines: ObjLines, points: IntArray) -> NDArray[np.uint8] | None:
    counts = lines.counts[points]
    if not (counts == counts[0]).all() or counts[0] not in (6, 7):
        return None
    width = int(counts[0]) - 3
    chosen = lines.heads[points][:, None] + 4 + np.arange(width)
    try:
        return rgba(parse_floats(lines.tokens, chosen.ravel()).reshape(-1, width))
    except FormatError:
        return None


def _aligned(
    corners: IntArray,
    triangles: IntArray,
    points: int,
    tables: list[FloatArray | None],
    colors: NDArray[np.uint8] | None,
    other: tuple[str, ...],
) -> Attributes:
    if tables[0] is None and tables[1] is None:
        return Attributes(colors=colors, other=other)
    idle = np.setdiff1d(np.arange(points), corners[:, 0])
    rows = np.concatenate([corners, np.stack([idle, 0 * idle, 0 * idle], axis=1)])
    distinct, place = np.unique(rows, axis=0, return_inverse=True)
    owner = distinct[:, 0]
    texcoords, normals = (
        None if table is None else table[distinct[:, field]] for field, table in enumerate(tables, 1)
    )
    seams = None
    if len(distinct) != points:
        seams = (owner, place.reshape(-1)[triangles])
    return Attributes(normals, texcoords, None if colors is None else colors[owner], other, seams)

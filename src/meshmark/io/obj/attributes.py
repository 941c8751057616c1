"""What an OBJ file holds beside positions and faces, for a conversion to another format."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes
from meshmark.errors import FormatError
from meshmark.io.colors import rgba
from meshmark.io.obj.keyword_lines import Rows, corner_indices, obj_lines
from meshmark.io.polygons import fan_corners
from meshmark.io.text.numbers import parse_floats
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
    lines = obj_lines(data, (b"v", b"vt", b"vn", b"f"), _ELSEWHERE)
    points, polygons = lines.rows[b"v"], lines.rows[b"f"]
    other = [name for word, name in _ELSEWHERE.items() if lines.census[word]]
    other += ["polygons"] * bool((polygons.counts > 3).any())
    corners = np.full((int(polygons.counts.sum()), 3), -1, dtype=np.int64)
    corners[:, 0] = corner_indices(polygons, 0, points)
    tables = []
    for field, (word, width, name) in enumerate(
        ((b"vt", 2, "texture coordinates"), (b"vn", 3, "normals")), 1
    ):
        table = _table(lines.rows[word], width, word.decode())
        if table is not None:
            indices = corner_indices(polygons, field, lines.rows[word])
            if (indices < 0).any():
                other += [f"{name} of some faces"] if (indices >= 0).any() else [f"unused {name}"]
                table = None
            else:
                corners[:, field] = indices
        tables.append(table)
    colors = _colors(points)
    other += ["vertex colours of some vertices"] * bool(colors is None and (points.counts >= 6).any())
    triangles = fan_corners(polygons.counts)
    held = Attributes(
        texcoords=tables[0], normals=tables[1], colors=colors, other=tuple(dict.fromkeys(other))
    )
    return _aligned(held, corners, triangles, len(points))


def _table(rows: Rows, width: int, name: str) -> FloatArray | None:
    if not len(rows):
        return None
    # A texture coordinate may have one number only: its second is zero.
    single = width == 2 and bool((rows.counts == 1).all())
    starts, ends = rows.columns(0, 1 if single else width, name)
    numbers = parse_floats(rows.text, starts.ravel(), ends.ravel(), finite=False).reshape(len(rows), -1)
    return np.pad(numbers, ((0, 0), (0, 1))) if single else numbers


def _colors(points: Rows) -> NDArray[np.uint8] | None:
    counts = points.counts
    if not (counts == counts[0]).all() or counts[0] not in (6, 7):
        return None
    starts, ends = points.columns(3, int(counts[0]) - 3, "v")
    try:
        return rgba(parse_floats(points.text, starts.ravel(), ends.ravel()).reshape(len(points), -1))
    except FormatError:
        return None


def _aligned(held: Attributes, corners: IntArray, triangles: IntArray, points: int) -> Attributes:
    """Return the attributes with a row for each distinct corner.

    held: texture coordinates and normals as the file's tables have them, colours by point. corners: (k, 3) the
    position, texture and normal index of each corner; triangles: (m, 3) rows of these; points: how many there are.
    """
    if held.texcoords is None and held.normals is None:
        return held
    idle = np.setdiff1d(np.arange(points), corners[:, 0])
    rows = np.concatenate([corners, np.stack([idle, 0 * idle, 0 * idle], axis=1)])
    distinct, place = np.unique(rows, axis=0, return_inverse=True)
    owner = distinct[:, 0]
    texcoords, normals = (
        None if table is None else table[distinct[:, field]]
        for field, table in enumerate((held.texcoords, held.normals), 1)
    )
    seams = None
    if len(distinct) != points:
        seams = (owner, place.reshape(-1)[triangles])
    return replace(
        held,
        normals=normals,
        texcoords=texcoords,
        colors=None if held.colors is None else held.colors[owner],
        seams=seams,
    )

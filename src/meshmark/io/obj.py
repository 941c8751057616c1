"""Wavefront OBJ: `v` and `f` lines are read, every other line is kept as it is."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.obj_attributes import obj_attributes
from meshmark.io.obj_lines import obj_lines
from meshmark.io.obj_materials import material_files
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.polygons import fan_corners
from meshmark.io.text_positions import text_positions

__all__ = ["parse_obj"]


def parse_obj(data: bytes, path: Path) -> PatchDocument:
    """Read an OBJ file. Raises `FormatError` where it breaks the format."""
    lines = obj_lines(data)
    points, polygons = np.flatnonzero(lines.keyword(b"v")), np.flatnonzero(lines.keyword(b"f"))
    if not len(points):
        raise FormatError("the file has no 'v' lines, expected an OBJ file with vertices")
    positions = text_positions(data, lines.tokens, lines.columns(points, 3, "v").reshape(-1, 3))
    sizes = lines.counts[polygons]
    if (sizes < 1).any():
        line = int(lines.heads[polygons[np.argmax(sizes < 1)]])
        raise FormatError(f"line {lines.tokens.line(line)}: a face without corners, expected at least three")
    faces = lines.indices(0, polygons, points)[fan_corners(sizes)]
    facts = {
        "encoding": "text",
        "polygons": bool((sizes > 3).any()),
        "texture_coordinates": int(lines.keyword(b"vt").sum()),
        "normals": int(lines.keyword(b"vn").sum()),
        "vertex_colors": bool((lines.counts[points] >= 6).all()),
        "groups": int(lines.keyword(b"g").sum() + lines.keyword(b"o").sum()),
        "materials": int(lines.keyword(b"usemtl").sum()),
    }
    return patch_document(
        "obj", positions, faces, partial(obj_attributes, data), facts, material_files(data, path)
    )

"""Wavefront OBJ: `v` and `f` lines are read, every other line is kept as it is."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from meshmark.document import Deviation
from meshmark.errors import FormatError
from meshmark.io.obj.attributes import obj_attributes
from meshmark.io.obj.keyword_lines import corner_indices, obj_lines
from meshmark.io.obj.materials import material_files
from meshmark.io.obj.obj_paint import obj_paint
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.polygons import fan_corners
from meshmark.io.text.positions import text_positions
from meshmark.io.wording import amount

__all__ = ["parse_obj"]


def parse_obj(data: bytes, path: Path) -> PatchDocument:
    """Read an OBJ file. Raises `FormatError` where it breaks the format."""
    lines = obj_lines(data, (b"v", b"f", b"mtllib"), (b"vt", b"vn", b"o", b"g", b"usemtl", b"l", b"p"))
    points, polygons = lines.rows[b"v"], lines.rows[b"f"]
    if not len(points):
        raise FormatError("the file has no 'v' lines, expected an OBJ file with vertices")
    positions = text_positions(data, *points.columns(0, 3, "v"))
    faces = corner_indices(polygons, 0, points)[fan_corners(polygons.counts)]
    facts = {
        "encoding": "text",
        "polygons": bool((polygons.counts > 3).any()),
        "texture_coordinates": lines.census[b"vt"],
        "normals": lines.census[b"vn"],
        "vertex_colors": bool((points.counts >= 6).all()),
        "groups": lines.census[b"o"] + lines.census[b"g"],
        "materials": lines.census[b"usemtl"],
    }
    references = material_files(lines.rows[b"mtllib"], path)
    hollow = int((polygons.counts < 1).sum())
    remarks = (
        (f"{amount(hollow, 'face', 'faces')} without corners: kept, and no part of the surface",)
        if hollow
        else ()
    )
    load = partial(obj_attributes, data)
    shown_too = tuple(
        Deviation(kind=kind, amount=1.0)
        for kind, word in (("lines", b"l"), ("points", b"p"))
        if lines.census[word]
    )
    return patch_document(
        "obj",
        positions,
        faces,
        load,
        facts=facts,
        references=references,
        remarks=remarks,
        gaps=positions.gaps,
        shown_too=shown_too,
        load_paint=partial(obj_paint, data, path),
    )

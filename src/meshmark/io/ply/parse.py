"""PLY as text and in both binary byte orders, with properties and elements of any kind."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from meshmark.arrays import members
from meshmark.document import Deviation
from meshmark.errors import FormatError
from meshmark.io.binary_data import BinaryData
from meshmark.io.binary_positions import BinaryPositions, binary_positions
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.ply.attributes import ply_attributes
from meshmark.io.ply.columns import Columns, lay_out
from meshmark.io.ply.data import PlyData, TextData
from meshmark.io.ply.header import PlyHeader, parse_header
from meshmark.io.polygons import fan_corners, strip_triangles
from meshmark.io.text.positions import TextPositions, text_positions
from meshmark.io.text.tokens import tokenise
from meshmark.mesh import IntArray

__all__ = ["parse_ply"]

_INDICES = ("vertex_indices", "vertex_index")


def parse_ply(data: bytes, _path: Path) -> PatchDocument:
    """Read a PLY file. Raises `FormatError` where it breaks the format."""
    header = parse_header(data)
    source = _source(data, header)
    columns, remarks = lay_out(header, source)
    positions = _positions(data, source, columns.get("vertex"))
    sizes, corners = _corners(source, columns.get("face"))
    faces = [corners[fan_corners(sizes)], _strips(source, columns.get("tristrips"))]
    facts = {
        "encoding": {"": "text", "<": "binary, little-endian", ">": "binary, big-endian"}[header.order],
        "polygons": bool((sizes > 3).any()),
        "elements": {entry.name: [item.name for item in entry.properties] for entry in header.elements},
    }
    load = partial(ply_attributes, header, source, columns, bool((sizes > 3).any()))
    gaps, together = positions.gaps, np.concatenate(faces)
    edges = any(entry.name == "edge" and entry.rows for entry in header.elements)
    shown_too = (Deviation(kind="lines", amount=1.0),) if edges else ()
    return patch_document(
        "ply", positions, together, load, facts=facts, remarks=remarks, gaps=gaps, shown_too=shown_too
    )


def _source(data: bytes, header: PlyHeader) -> PlyData:
    if header.order:
        return BinaryData(data=data, begin=header.size, end=len(data))
    return TextData(tokens=tokenise(data, header.size))


def _positions(data: bytes, source: PlyData, vertex: Columns | None) -> BinaryPositions | TextPositions:
    entries = [] if vertex is None else [vertex.element.find(name) for name in "xyz"]
    if vertex is None or not vertex.element.rows or not all(entries):
        raise FormatError("the file has no element 'vertex' with properties x, y and z")
    types = [entry.dtype for entry in entries if entry is not None]
    if any(name in vertex.counts for name in "xyz"):
        raise FormatError("a coordinate of the element 'vertex' is a list, expected a number")
    places = [vertex.places[name] for name in "xyz"]
    if not isinstance(source, TextData):
        return binary_positions(data, places, types)
    whole = all(dtype.kind != "f" for dtype in types)
    chosen = np.stack(places, axis=1)
    return text_positions(data, source.tokens.starts[chosen], source.tokens.ends[chosen], whole)


def _corners(source: PlyData, face: Columns | None) -> tuple[IntArray, IntArray]:
    """Return the corners per face, and all corners."""
    entry = None if face is None else face.element.find(*_INDICES)
    if face is None or entry is None or entry.count is None or not len(face.counts[entry.name]):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    if entry.dtype.kind == "f":
        raise FormatError(f"the list '{entry.name}' of the faces has real numbers, expected whole ones")
    sizes, places = face.counts[entry.name], face.places[entry.name]
    if sizes[0] > 0 and (sizes == sizes[0]).all():
        return sizes, source.lists(places, entry.dtype, int(sizes[0])).astype(np.int64).ravel()
    group, place = members(sizes)
    return sizes, source.values(places[group] + place * source.width(entry.dtype), entry.dtype).astype(
        np.int64
    )


def _strips(source: PlyData, strips: Columns | None) -> IntArray:
    sizes, corners = _corners(source, strips)
    begins = np.cumsum(sizes) - sizes
    return strip_triangles(np.insert(corners, begins, -1))

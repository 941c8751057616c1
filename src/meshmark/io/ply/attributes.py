"""What a PLY file holds beside positions and faces, for a conversion to another format."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes
from meshmark.io.colors import ODD_COLORS, rgba
from meshmark.io.ply.columns import Columns
from meshmark.io.ply.data import PlyData
from meshmark.io.ply.header import PlyHeader
from meshmark.mesh import FloatArray

__all__ = ["ply_attributes"]

_TEXCOORDS = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_COLORS = (("red", "green", "blue", "alpha"), ("red", "green", "blue"), ("r", "g", "b", "a"), ("r", "g", "b"))
_KNOWN_FACE = {"vertex_indices", "vertex_index"}


def ply_attributes(
    header: PlyHeader, source: PlyData, columns: dict[str, Columns], polygons: bool
) -> Attributes:
    """Return normals, texture coordinates and colours of the vertices, and the names of all else."""
    vertex = columns["vertex"]
    used = {"x", "y", "z"}

    def numbers(*groups: tuple[str, ...]) -> FloatArray | None:
        for names in groups:
            entries = [vertex.element.find(name) for name in names]
            if all(entry is not None and entry.count is None for entry in entries):
                used.update(names)
                return _numbers(source, vertex, names)
        return None

    normals, texcoords, shades = numbers(("nx", "ny", "nz")), numbers(*_TEXCOORDS), numbers(*_COLORS)
    colors: NDArray[np.uint8] | None = None
    if shades is not None and np.isfinite(shades).all():
        entry = vertex.element.find("red", "r")
        colors = rgba(
            shades, unit=entry is not None and entry.dtype.kind == "f" and bool((shades <= 1).all())
        )
    other = [f"vertex property {item.name}" for item in vertex.element.properties if item.name not in used]
    for element in header.elements:
        if element.name == "face":
            other += [f"face property {p.name}" for p in element.properties if p.name not in _KNOWN_FACE]
        elif element.name not in ("vertex", "tristrips") and element.rows:
            other.append(f"element {element.name}")
    other += ["polygons"] * polygons
    if shades is not None and not np.isfinite(shades).all():
        colors, other = None, [*other, ODD_COLORS]
    return Attributes(normals=normals, texcoords=texcoords, colors=colors, other=tuple(other))


def _numbers(source: PlyData, vertex: Columns, names: tuple[str, ...]) -> FloatArray:
    columns = [
        source.values(vertex.places[name], entry.dtype)
        for name in names
        if (entry := vertex.element.find(name)) is not None
    ]
    return np.stack(columns, axis=1).astype(np.float64)

"""A fresh PLY file: binary, little-endian, in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_ply"]

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def convert_ply(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return a PLY file of (n, 3) vertices and (m, 3) faces, and what it cannot keep."""
    columns: list[tuple[str, str, NDArray[Any] | None]] = [
        ("x y z", "double", vertices),
        ("nx ny nz", "double", attributes.normals),
        ("s t", "double", attributes.texcoords),
        ("red green blue alpha", "uchar", attributes.colors),
    ]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    fields: list[tuple[str, str]] = []
    for names, kind, values in columns:
        if values is not None:
            lines += [f"property {kind} {item}" for item in names.split()]
            fields += [(item, "<f8" if kind == "double" else "u1") for item in names.split()]
    rows = np.empty(len(vertices), dtype=fields)
    for names, _, values in columns:
        if values is not None:
            for axis, item in enumerate(names.split()):
                rows[item] = values[:, axis]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    corners = np.empty(len(faces), dtype=_FACE)
    corners["count"], corners["corners"] = 3, faces
    return {name: "\n".join(lines).encode("ascii") + rows.tobytes() + corners.tobytes()}, attributes.other

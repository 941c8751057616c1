"""A fresh OFF file, with the header that its columns need."""

from __future__ import annotations

from meshmark.document import Attributes
from meshmark.io.text.new_lines import index_lines, number_lines
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_off"]


def convert_off(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return an OFF file of (n, 3) vertices and (m, 3) faces in full precision, and what it cannot keep."""
    colors = attributes.colors
    columns = [vertices, attributes.normals, colors, attributes.texcoords]
    magic = (
        "ST" * (attributes.texcoords is not None)
        + "C" * (colors is not None)
        + "N" * (attributes.normals is not None)
        + "OFF"
    )
    lines = number_lines("", [column for column in columns if column is not None])
    corners = index_lines("3 ", [faces], 0)
    text = f"{magic}\n{len(vertices)} {len(faces)} 0\n{lines}{corners}"
    return {name: text.encode("ascii")}, attributes.other

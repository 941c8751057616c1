"""A fresh OBJ file."""

from __future__ import annotations

import numpy as np

from meshmark.document import Attributes
from meshmark.io.text.new_lines import index_lines, number_lines
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_obj"]


def convert_obj(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return an OBJ file of (n, 3) vertices and (m, 3) faces in full precision, and what it cannot keep.

    Colours follow the coordinates on the `v` lines, 0 to 1, without opacity.
    """
    dropped = list(attributes.other)
    points: list[FloatArray] = [vertices]
    if attributes.colors is not None:
        points.append(np.round(attributes.colors[:, :3] / 255, 6))
        dropped += ["opacity"] * bool((attributes.colors[:, 3] != 255).any())
    text = number_lines("v ", points)
    if attributes.texcoords is not None:
        text += number_lines("vt ", [attributes.texcoords])
    if attributes.normals is not None:
        text += number_lines("vn ", [attributes.normals])
    extra = (attributes.texcoords is not None) + (attributes.normals is not None)
    joint = "//" if attributes.texcoords is None else "/"
    text += index_lines("f ", [faces] * (1 + extra), 1, joint)
    return {name: text.encode("ascii")}, tuple(dropped)

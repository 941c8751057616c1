"""A fresh STL file: binary."""

from __future__ import annotations

import numpy as np

from meshmark.document import Attributes
from meshmark.io.binary_positions import round_to_type
from meshmark.io.stl.binary import FACET
from meshmark.io.stl.normals import facet_normals
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_stl"]

# A binary file must not start with the word `solid`.
_HEADER = b"binary STL".ljust(80)


def convert_stl(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return an STL file of the facets in float32, with their normals, and what it cannot keep.

    Raises `InputError` where a coordinate is beyond the range of float32.
    """
    corners = round_to_type(vertices, np.dtype("<f4"))[faces]
    records = np.zeros(len(faces), dtype=FACET)
    records["corners"], records["normal"] = corners, facet_normals(corners)
    count = len(faces).to_bytes(4, "little")
    return {name: _HEADER + count + records.tobytes()}, attributes.other

"""Small binary PLY and STL files, packed byte by byte with `struct`."""

from __future__ import annotations

import struct

import numpy as np

POINTS = np.array([[0, 0, 0], [1.5, 0, 0], [0, 2.25, 0], [0, 0, -3]])
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
TYPES = {
    "char": "b",
    "uchar": "B",
    "int16": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "float": "f",
    "double": "d",
}


def binary_ply(
    order: str, kinds: tuple[str, str, str], *, lists: bool = False, polygons: bool = False
) -> tuple[bytes, list[int]]:
    """Return a binary PLY file with extra properties and elements, and the offsets of its coordinates."""
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = ["ply", f"format {name} 1.0", "comment element vertex 9", "obj_info x", "element camera 2"]
    header += ["property list uchar ushort view", "property double gain", f"element vertex {len(POINTS)}"]
    header += ["property uchar red", f"property {kinds[2]} z", f"property {kinds[0]} x"]
    header += ["property list int double tags"] * lists + [f"property {kinds[1]} y", "property float nx"]
    faces = [(0, 2, 1, 3), (0, 1, 3)] if polygons else list(FACES)
    header += [
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "property uchar red",
        "end_header",
        "",
    ]
    data = bytearray("\n".join(header).encode())
    for view in ((1, 2), (3,)):
        data += struct.pack(f"{order}B{len(view)}Hd", len(view), *view, 0.5)
    offsets = []
    for row, (x, y, z) in enumerate(POINTS):
        data += bytes([7])
        spots = {}
        for axis, value in (("z", z), ("x", x), ("y", y)):
            if axis == "y" and lists:
                data += struct.pack(f"{order}i{row}d", row, *[9.5] * row)
            kind = TYPES[kinds["xyz".index(axis)]]
            spots[axis] = len(data)
            data += struct.pack(order + kind, value if kind in "fd" else int(value))
        offsets += [spots[axis] for axis in "xyz"]
        data += struct.pack(order + "f", -0.5)
    for face in faces:
        data += struct.pack(f"{order}B{len(face)}iB", len(face), *face, 200)
    return bytes(data), offsets


CORNERS = np.array(
    [
        [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[5, 5, 5]] * 3,
    ]
).astype(float)
# Right, zero, wrong, and of a facet without area.
NORMALS = [(0.0, 0.0, -1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]


def binary_stl(header: bytes = b"made by a test") -> bytes:
    """Return a binary STL file of the facets above, each with attribute bytes."""
    body = b"".join(
        struct.pack("<12fH", *normal, *corners.ravel(), 1000 + k)
        for k, (normal, corners) in enumerate(zip(NORMALS, CORNERS, strict=True))
    )
    return header.ljust(80) + struct.pack("<I", len(CORNERS)) + body

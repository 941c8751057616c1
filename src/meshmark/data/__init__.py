"""The model that comes with meshmark: a hare, our own work, made by `tools/make_demo_model.py`."""

from __future__ import annotations

from importlib import resources

__all__ = ["hare_ply"]

_HEADER = """ply
format binary_little_endian 1.0
comment The meshmark hare, made by tools/make_demo_model.py, MIT
element vertex {points}
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face {faces}
property list uchar int vertex_indices
end_header
"""


def hare_ply() -> bytes:
    """Return the hare as a binary PLY file of 25,178 vertices with colours."""
    import numpy as np

    from meshmark.data.packing import unpacked

    points, faces, colours = unpacked((resources.files("meshmark.data") / "hare.drc").read_bytes())
    vertices = np.empty(len(points), [("position", "<f4", 3), ("colour", "u1", 3)])
    vertices["position"], vertices["colour"] = points, colours
    triangles = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    header = _HEADER.format(points=len(points), faces=len(faces)).encode()
    return header + vertices.tobytes() + triangles.tobytes()

"""A binary PLY file of triangles in fewer bytes: its faces as small differences, byte plane by byte plane, in xz.

Faces in the order of their first corner, told as the step from the last first corner and the other corners from
there, are small numbers; xz makes little of their rows, and much of planes of equal bytes.
"""

from __future__ import annotations

import lzma

import numpy as np

__all__ = ["packed", "unpacked"]

_TRIANGLE = np.dtype([("count", "u1"), ("corner", "<i4", 3)])


def packed(ply: bytes, faces: int) -> bytes:
    """Return a PLY file whose last part is so many triangles, with 32-bit indices, in fewer bytes."""
    cut = len(ply) - faces * _TRIANGLE.itemsize
    first, *others = np.frombuffer(ply, _TRIANGLE, faces, cut)["corner"].T
    steps = np.stack([np.diff(first, prepend=0), *(other - first for other in others)]).astype("<i4")
    planes = steps.view("u1").reshape(-1, 4).T.tobytes()
    head = np.array([cut, faces], "<u4").tobytes()
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME}]
    return lzma.compress(head + ply[:cut] + planes, check=lzma.CHECK_CRC32, filters=filters)


def unpacked(content: bytes) -> bytes:
    """Undo `packed`: the PLY file to the byte."""
    raw = lzma.decompress(content)
    cut, faces = (int(number) for number in np.frombuffer(raw, "<u4", 2))
    planes = np.frombuffer(raw, "u1", offset=8 + cut).reshape(4, -1)
    steps = np.ascontiguousarray(planes.T).view("<i4").reshape(3, faces)
    first = np.cumsum(steps[0], dtype="<i4")
    triangles = np.empty(faces, _TRIANGLE)
    triangles["count"] = 3
    triangles["corner"] = np.stack([first, first + steps[1], first + steps[2]], axis=1)
    return raw[8 : 8 + cut] + triangles.tobytes()

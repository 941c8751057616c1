"""A software rasteriser: which triangle is seen at each pixel."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import members
from meshmark.mesh import FloatArray, IntArray

__all__ = ["EMPTY", "rasterise"]

EMPTY = -1
PIXELS_AT_ONCE = 1 << 21
"""Candidate pixels held in memory at a time."""
_BEHIND = np.uint64(0xFFFFFFFFFFFFFFFF)


def rasterise(screen: FloatArray, faces: IntArray, width: int, height: int) -> NDArray[np.int64]:
    """Return (height, width): the nearest face at each pixel centre, or EMPTY.

    screen: (p, 3) pixel x to the right, pixel y downwards, depth away from the viewer in [0, 1].
    """
    buffer = np.full(width * height, _BEHIND)
    corners = screen[faces]
    order = np.argsort(corners[:, :, 1], axis=1)
    corners = np.take_along_axis(corners, order[:, :, None], axis=1)  # from the top corner to the lowest
    first_row = np.clip(np.ceil(corners[:, 0, 1] - 0.5), 0, height).astype(np.int64)
    rows = np.clip(np.ceil(corners[:, 2, 1] - 0.5), 0, height).astype(np.int64) - first_row
    for chunk in _chunks(rows, PIXELS_AT_ONCE // 8):
        strips = _Strips(faces=np.arange(chunk.start, chunk.stop), first=first_row[chunk], count=rows[chunk])
        _fill(buffer, corners[chunk], strips, width)
    seen: NDArray[np.int64] = np.where(buffer == _BEHIND, EMPTY, (buffer & 0xFFFFFFFF).astype(np.int64))
    return seen.reshape(height, width)


def _chunks(sizes: IntArray, most: int) -> list[slice]:
    """Cut a list of sizes into runs of about `most` in all."""
    turns = np.flatnonzero(np.diff(np.cumsum(sizes) // most)) + 1
    bounds = [0, *turns.tolist(), len(sizes)]
    return [slice(a, b) for a, b in pairwise(bounds) if b > a]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Strips:
    """The pixel rows of k faces: the number of each face, its first row, and how many rows it has, all (k,)."""

    faces: IntArray
    first: IntArray
    count: IntArray


def _fill(buffer: NDArray[np.uint64], corners: FloatArray, strips: _Strips, width: int) -> None:
    """Cut faces into pixel rows, rows into pixels, and keep the nearest face at each pixel."""
    face, down = members(strips.count)
    y = strips.first[face] + down
    (xa, ya, za), (xb, yb, zb), (xc, yc, zc) = corners.transpose(1, 2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        long, upper, lower = (xc - xa) / (yc - ya), (xb - xa) / (yb - ya), (xc - xb) / (yc - yb)
        turn = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        slope_x = ((zb - za) * (yc - ya) - (zc - za) * (yb - ya)) / turn
        slope_y = ((zc - za) * (xb - xa) - (zb - za) * (xc - xa)) / turn
    line = y + 0.5
    one = xa[face] + (line - ya[face]) * long[face]
    knee = line >= yb[face]  # below its middle corner the other side follows the lower edge
    side_x, side_y = np.where(knee, xb[face], xa[face]), np.where(knee, yb[face], ya[face])
    other = side_x + (line - side_y) * np.where(knee, lower[face], upper[face])
    left = np.clip(np.ceil(np.minimum(one, other) - 0.5), 0, width)
    count = np.clip(np.ceil(np.maximum(one, other) - 0.5), 0, width) - left
    kept = (count > 0) & np.isfinite(slope_x[face])
    face, y, line, left, count = face[kept], y[kept], line[kept], left[kept], count[kept].astype(np.int64)
    start = za[face] + (left + 0.5 - xa[face]) * slope_x[face] + (line - ya[face]) * slope_y[face]
    step = slope_x[face]
    place = y * width + left.astype(np.int64)
    name = strips.faces[face].astype(np.uint64)
    for chunk in _chunks(count, PIXELS_AT_ONCE):
        row, along = members(count[chunk])
        row += chunk.start
        depth = np.clip(start[row] + along * step[row], 0.0, 1.0).astype(np.float32)
        # The bits of a float that is not negative sort as the number does: depth first, then the face.
        key = (depth.view(np.uint32).astype(np.uint64) << np.uint64(32)) | name[row]
        np.minimum.at(buffer, place[row] + along, key)

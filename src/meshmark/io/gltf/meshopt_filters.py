"""The filters of the meshopt compression extensions: from decoded rows to the numbers that accessors read.

OCTAHEDRAL: unit vectors, QUATERNION: rotations by their three smaller components, EXPONENTIAL: 24-bit mantissas
with an 8-bit exponent, COLOR: luma and chroma with alpha. All in 32-bit floating point, as the reference computes.
Source: the specification of EXT_meshopt_compression and KHR_meshopt_compression (Khronos glTF registry).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["FILTERS"]

Bytes = NDArray[np.uint8]
_HALF = np.float32(0.5)


def _octahedral(rows: Bytes) -> Bytes:
    dtype = np.dtype("<i1" if rows.shape[1] == 4 else "<i2")
    stored = np.ascontiguousarray(rows).view(dtype).copy()
    x, y, one = (stored[:, i].astype(np.float32) for i in range(3))
    z = one - np.abs(x) - np.abs(y)
    below = np.minimum(z, np.float32(0))
    x = x + np.where(x >= 0, below, -below)
    y = y + np.where(y >= 0, below, -below)
    length = np.sqrt(x * x + (y * y + z * z))
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.float32(np.iinfo(dtype).max) / length
        for axis, value in enumerate((x, y, z)):
            stored[:, axis] = _rounded(value * scale).astype(dtype)
    return stored.view(np.uint8)


def _quaternion(rows: Bytes) -> Bytes:
    stored = np.ascontiguousarray(rows).view("<i2")
    scale = (stored[:, 3] | 3).astype(np.float32)
    x, y, z = (stored[:, i].astype(np.float32) for i in range(3))
    rest = scale * scale * np.float32(2) - (x * x + (y * y + z * z))
    w = np.sqrt(np.maximum(rest, np.float32(0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = np.float32(32767) / np.sqrt(np.float32(2)) / scale
        values = [_rounded(value * unit).astype("<i2") for value in (x, y, z, w)]
    largest = stored[:, 3].astype(np.int64) & 3
    out = np.empty_like(stored)
    line = np.arange(len(stored))
    for step, value in zip((1, 2, 3, 0), values, strict=True):
        out[line, (largest + step) & 3] = value
    return out.view(np.uint8)


def _exponential(rows: Bytes) -> Bytes:
    stored = np.ascontiguousarray(rows).view("<i4")
    mantissa = (stored << 8 >> 8).astype(np.float32)
    power = ((stored >> 24) + 127).astype(np.uint32) << np.uint32(23)
    with np.errstate(over="ignore", invalid="ignore"):
        return (mantissa * power.view(np.float32)).astype("<f4").view(np.uint8)


def _color(rows: Bytes) -> Bytes:
    wide = rows.shape[1] == 8
    stored = np.ascontiguousarray(rows).view("<u2" if wide else "<u1")
    signed = stored.view("<i2" if wide else "<i1").astype(np.int64)
    alpha = stored[:, 3].astype(np.int64)
    full = alpha.copy()
    for shift in (1, 2, 4, 8):
        full |= full >> shift
    y, co, cg = stored[:, 0].astype(np.int64), signed[:, 1], signed[:, 2]
    values = (y + co - cg, y + cg, y - co - cg, (alpha << 1 & full) | (alpha & 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.float32(65535 if wide else 255) / full.astype(np.float32)
        scaled = [_whole(value.astype(np.float32) * scale + _HALF) for value in values]
    return np.stack(scaled, axis=1).astype(stored.dtype).view(np.uint8)


def _rounded(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Round to the nearest whole number, halves to the even one."""
    return _whole(np.rint(values))


def _whole(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Cut off to whole numbers; what no integer holds (a broken stream) is 0."""
    return np.trunc(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)).astype(np.int64)


# Each takes rows (n, stride) of uint8 and returns rows of the same shape; the strides that it takes.
FILTERS: dict[str, tuple[Callable[[Bytes], Bytes], tuple[int, ...]]] = {
    "NONE": (lambda rows: rows, tuple(range(4, 257, 4))),
    "OCTAHEDRAL": (_octahedral, (4, 8)),
    "QUATERNION": (_quaternion, (8,)),
    "EXPONENTIAL": (_exponential, tuple(range(4, 257, 4))),
    "COLOR": (_color, (4, 8)),
}

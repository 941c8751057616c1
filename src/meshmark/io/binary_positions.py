"""The coordinates of a binary file: read from their bytes, and patched back into them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.errors import FormatError, InputError
from meshmark.io.binary_data import BinaryData, Type, strided
from meshmark.io.gaps import Gaps
from meshmark.mesh import FloatArray, IntArray

__all__ = ["BinaryPositions", "binary_positions", "put_values", "round_to_type"]


@dataclass(frozen=True, eq=False, kw_only=True)
class BinaryPositions:
    """Coordinates that stand as numbers in bytes.

    data:   the file.
    places: for x, y and z the (n,) ascending byte offsets; types: their types with byte order.
    values: (n, 3) what they say.
    gaps:   rows of the file that are left out, None where there are none.
    """

    data: bytes
    places: tuple[IntArray, ...]
    types: tuple[Type, ...]
    values: FloatArray
    gaps: Gaps | None = None

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold for these.

        Raises `InputError` where they are beyond the range of the file's numbers.
        """
        if np.shape(vertices) != self.values.shape or not np.isfinite(vertices).all():
            raise InputError(f"new positions must be finite and of shape {self.values.shape}")
        rounded = np.empty_like(self.values)
        for axis, dtype in enumerate(self.types):
            rounded[:, axis] = round_to_type(vertices[:, axis], dtype)
        return np.where(vertices == self.values, self.values, rounded + 0.0)

    def patch(self, vertices: FloatArray) -> bytes:
        """Return the file with the changed coordinates in their type."""
        rounded = self.conform(vertices)
        out = bytearray(self.data)
        for axis, (places, dtype) in enumerate(zip(self.places, self.types, strict=True)):
            put_values(out, places, dtype, rounded[:, axis], rounded[:, axis] != self.values[:, axis])
        return bytes(out)

    def describe(self) -> str:
        """Return the types of the coordinates in words."""
        return ", ".join(dict.fromkeys(dtype.newbyteorder("=").name for dtype in self.types))


def put_values(out: bytearray, places: IntArray, dtype: Type, values: FloatArray, changed: Any) -> None:
    """Write the changed ones of the (k,) values at their byte offsets."""
    view = strided(out, places, dtype)
    if view is not None:
        np.copyto(view[:, 0], values, where=changed, casting="unsafe")
        return
    letters = np.frombuffer(out, dtype=np.uint8)
    fresh = values[changed].astype(dtype).view(np.uint8).reshape(-1, dtype.itemsize)
    letters[places[changed][:, None] + np.arange(dtype.itemsize)] = fresh


def binary_positions(data: bytes, places: Sequence[IntArray], types: Sequence[Type]) -> BinaryPositions:
    """Read coordinates at these byte offsets; rows that are not finite are left out.

    Raises `FormatError` where all are.
    """
    source = BinaryData(data=data, begin=0, end=len(data))
    values = np.empty((len(places[0]), 3))
    for axis in range(3):
        values[:, axis] = source.values(places[axis], types[axis])
    finite = np.asarray(np.isfinite(values).all(axis=1))
    if finite.all():
        return BinaryPositions(data=data, places=tuple(places), types=tuple(types), values=values)
    gaps = Gaps(kept=np.flatnonzero(finite), total=len(finite), say=_not_finite)
    if not finite.any():
        raise FormatError(_not_finite(0))
    kept = tuple(column[finite] for column in places)
    return BinaryPositions(data=data, places=kept, types=tuple(types), values=values[finite], gaps=gaps)


def _not_finite(row: int) -> str:
    return f"vertex {row} has a coordinate that is not a finite number"


def round_to_type(column: FloatArray, dtype: Type) -> FloatArray:
    """Return what `dtype` holds for these numbers. Raises `InputError` where they are out of its range."""
    if dtype.kind == "f":
        with np.errstate(over="ignore"):
            rounded = column.astype(dtype).astype(np.float64)
        inside = bool(np.isfinite(rounded).all())
    else:
        rounded, limits = np.rint(column), np.iinfo(dtype)
        inside = bool(((rounded >= limits.min) & (rounded <= limits.max)).all())
    if not inside:
        raise InputError(f"a new coordinate is beyond the range of the file's {dtype.newbyteorder('=').name}")
    return rounded

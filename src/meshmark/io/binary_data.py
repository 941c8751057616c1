"""Binary data: values of a type at byte offsets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import IntArray

__all__ = ["BinaryData", "Type", "strided"]

Type = np.dtype[Any]


def strided(
    buffer: bytes | bytearray, places: IntArray, dtype: Type, members: int = 1
) -> NDArray[Any] | None:
    """Return a (k, members) view of the values at evenly spaced byte offsets, or None if they are not."""
    stride = int(places[1] - places[0]) if len(places) > 1 else dtype.itemsize
    if not len(places) or not (np.diff(places) == stride).all():
        return None
    return np.ndarray((len(places), members), dtype, buffer, int(places[0]), (stride, dtype.itemsize))


@dataclass(frozen=True, eq=False, kw_only=True)
class BinaryData:
    """Binary data; types carry the byte order."""

    data: bytes
    begin: int
    end: int
    unit: tuple[str, str] = ("byte", "bytes")
    whole: bool = True

    def width(self, dtype: Type) -> int:
        """Return the bytes of one value."""
        return dtype.itemsize

    def count(self, place: int, dtype: Type) -> int:
        """Return the list length at a place."""
        order: Literal["big", "little"] = "big" if dtype.byteorder == ">" else "little"
        return int.from_bytes(self.data[place : place + dtype.itemsize], order, signed=dtype.kind == "i")

    def values(self, places: IntArray, dtype: Type) -> NDArray[Any]:
        """Return the (k,) values at ascending places."""
        return self.lists(places, dtype, 1)[:, 0]

    def lists(self, places: IntArray, dtype: Type, members: int) -> NDArray[Any]:
        """Return the (k, members) values of lists that begin at ascending places."""
        view = strided(self.data, places, dtype, members)
        if view is not None:
            return view
        size = dtype.itemsize * members
        letters = np.frombuffer(self.data, dtype=np.uint8)[places[:, None] + np.arange(size)]
        return np.asarray(letters.view(dtype).reshape(-1, members))

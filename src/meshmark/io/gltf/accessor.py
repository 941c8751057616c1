"""glTF accessors: typed rows in the blob, plain, interleaved or sparse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.container import Bytes, Container
from meshmark.io.gltf.schema import Json, integer, reference
from meshmark.mesh import FloatArray, IntArray

__all__ = ["COMPONENTS", "WIDTHS", "Accessor", "Sparse", "component", "normalised", "open_accessor"]

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

# An accessor without a bufferView is all zeros and costs no bytes in the file: this bounds its memory.
_MOST_ZEROS = 4_000_000


@dataclass(frozen=True, eq=False, kw_only=True)
class Sparse:
    """These `rows` of an accessor lie densely at address `values`; the row numbers lie at `indices`."""

    rows: IntArray
    values: int
    indices: int
    index_bytes: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Accessor:
    """`count` rows of `width` components.

    start:  address of the first row, or None where rows without sparse data are zeros.
    stride: bytes from row to row.
    sparse: rows that lie elsewhere instead.
    """

    index: int
    count: int
    width: int
    dtype: np.dtype[Any]
    normalized: bool
    start: int | None
    stride: int
    sparse: Sparse | None

    @property
    def row_bytes(self) -> int:
        """Bytes of one row (of small matrices, whose columns glTF pads, without the padding)."""
        return self.width * self.dtype.itemsize

    def raw(self, blob: Bytes) -> NDArray[Any]:
        """Return the rows (count, width) as stored, a view of the blob where possible."""
        if self.start is None:
            rows = np.zeros((self.count, self.width), self.dtype)
        else:
            rows = self._view(blob, self.start, self.count, self.stride)
        if self.sparse is not None:
            rows = rows.copy()
            count = len(self.sparse.rows)
            rows[self.sparse.rows] = self._view(blob, self.sparse.values, count, self.row_bytes)
        return rows

    def _view(self, blob: Bytes, start: int, count: int, stride: int) -> NDArray[Any]:
        strides = (stride, self.dtype.itemsize)
        return np.ndarray((count, self.width), self.dtype, blob.data, start, strides)

    def addresses(self) -> IntArray:
        """Return the address of each row, (count,); -1 where a row has no bytes."""
        rows = np.arange(self.count, dtype=np.int64)
        found = np.full(self.count, -1) if self.start is None else self.start + rows * self.stride
        if self.sparse is not None:
            within = rows[: len(self.sparse.rows)] * self.row_bytes
            found[self.sparse.rows] = self.sparse.values + within
        return found

    def values(self, blob: Bytes) -> FloatArray:
        """Return the rows (count, width) as the numbers they stand for."""
        return normalised(self.raw(blob), self.normalized)


def normalised(raw: NDArray[Any], normalized: bool) -> FloatArray:
    """Return stored components as numbers: glTF 2.0 section 3.6.2.2."""
    numbers = raw.astype(np.float64)
    if not normalized or raw.dtype.kind == "f":
        return numbers
    return np.maximum(numbers / np.iinfo(raw.dtype).max, -1.0)


def open_accessor(container: Container, index: int) -> Accessor:
    """Return accessor `index`, checked against the bytes there are. Raises `FormatError`."""
    item, where = container.tables["accessors"][index], f"accessor {index}"
    dtype, width = component(item, where), WIDTHS.get(str(item.get("type")))
    if width is None:
        raise FormatError(f"{where} has type {item.get('type')!r}, expected one of {', '.join(WIDTHS)}")
    count = integer(item, "count", where, None, 1)
    view = reference(item, "bufferView", where, container.tables["bufferViews"])
    start, stride = None, width * dtype.itemsize
    if view is not None:
        start, stride = _place(container, item, where, view, (count, width * dtype.itemsize))
    elif count > _MOST_ZEROS:
        raise FormatError(f"{where} has {count} rows and no bufferView, expected at most {_MOST_ZEROS}")
    sparse = None
    if "sparse" in item:
        sparse = _sparse(container, item["sparse"], where, count, width * dtype.itemsize)
    return Accessor(
        index=index,
        count=count,
        width=width,
        dtype=dtype,
        normalized=item.get("normalized") is True,
        start=start,
        stride=stride,
        sparse=sparse,
    )


def component(item: Json, where: str) -> np.dtype[Any]:
    """Return the type that an accessor's "componentType" stands for."""
    code = integer(item, "componentType", where)
    if code not in COMPONENTS:
        raise FormatError(f"{where} has componentType {code}, expected one of {list(COMPONENTS)}")
    return np.dtype(COMPONENTS[code])


def _place(
    container: Container, item: Json, where: str, view: int, shape: tuple[int, int], *, dense: bool = False
) -> tuple[int, int]:
    """Return the address of the first row and the stride of rows (count, bytes each) in a bufferView."""
    record = container.tables["bufferViews"][view]
    start, size = container.view_span(view)
    count, row_bytes = shape
    stride = row_bytes if dense else integer(record, "byteStride", f"bufferView {view}", row_bytes, 1)
    offset = integer(item, "byteOffset", where, 0)
    if stride < row_bytes:
        raise FormatError(f"bufferView {view} has a stride of {stride} bytes, {where} needs {row_bytes}")
    if offset + (count - 1) * stride + row_bytes > size:
        raise FormatError(f"{where} needs more than the {size} bytes of bufferView {view}")
    return start + offset, stride


def _sparse(container: Container, item: Any, where: str, count: int, row_bytes: int) -> Sparse:
    where = f"{where}, sparse"
    if not isinstance(item, dict):
        raise FormatError(f"{where} is not an object")
    number = integer(item, "count", where, None, 1)
    starts = []
    dtype = np.dtype("u1")
    for key in ("indices", "values"):
        part = item.get(key)
        if not isinstance(part, dict):
            raise FormatError(f"{where} has no {key}")
        view = reference(part, "bufferView", where, container.tables["bufferViews"])
        if view is None:
            raise FormatError(f"{where}: its {key} have no bufferView")
        if key == "indices":
            dtype = component(part, where)
        size = dtype.itemsize if key == "indices" else row_bytes
        starts.append(_place(container, part, where, view, (number, size), dense=True)[0])
    if dtype.kind != "u":
        raise FormatError(f"{where}: its indices have component type {dtype.name}, expected unsigned")
    rows = np.frombuffer(container.blob, dtype, number, starts[0]).astype(np.int64)
    if rows[-1] >= count or (np.diff(rows) <= 0).any():
        raise FormatError(f"{where}: its indices do not rise strictly below {count}")
    return Sparse(rows=rows, values=starts[1], indices=starts[0], index_bytes=dtype.itemsize)

"""Binary STL: an 80-byte header, a count, and 50 bytes per facet.

Writers that stream cannot know the count and leave a placeholder, and some miscount; then the length of the file
tells how many complete facets there are. What follows the facets counted is kept, unless it may be further facets.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes
from meshmark.errors import FormatError, InputError
from meshmark.io.binary_positions import round_to_type
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.stl.normals import facet_normals, stale_facets
from meshmark.io.wording import amount, surplus
from meshmark.mesh import FloatArray

__all__ = ["FACET", "HEAD", "parse_binary_stl"]

HEAD = 84
# A count that is wrong is not wrong by more than this factor, or the file is cut off or no STL.
_MOST_MISSED = 2
# Counts that stand for "not known".
_PLACEHOLDERS = (0, 0xFFFFFFFF)
# A facet lies within this many times the extent of the others about their middle; normals are about unit length.
_REACH, _LONGEST = 2.0, 1.01
_FLOAT = np.dtype("<f4")
FACET = np.dtype([("normal", _FLOAT, 3), ("corners", _FLOAT, (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, eq=False)
class _Positions:
    """The corners of the facets, three rows each."""

    data: bytes
    values: FloatArray

    def conform(self, vertices: FloatArray) -> FloatArray:
        if np.shape(vertices) != self.values.shape or not np.isfinite(vertices).all():
            raise InputError(f"new positions must be finite and of shape {self.values.shape}")
        return np.where(vertices == self.values, self.values, round_to_type(vertices, _FLOAT) + 0.0)

    def patch(self, vertices: FloatArray) -> bytes:
        rounded = self.conform(vertices).reshape(-1, 3, 3)
        before = self.values.reshape(-1, 3, 3)
        out = bytearray(self.data)
        records = np.frombuffer(out, dtype=FACET, count=len(before), offset=HEAD)
        stale = stale_facets(records["normal"].astype(np.float64), before, rounded)
        np.copyto(records["corners"], rounded, where=rounded != before, casting="unsafe")
        records["normal"][stale] = facet_normals(rounded[stale])
        return bytes(out)

    def describe(self) -> str:
        return "float32"


def parse_binary_stl(data: bytes) -> PatchDocument:
    """Read a binary STL file. Raises `FormatError` where it breaks the format."""
    if len(data) < HEAD:
        raise FormatError(f"the file has {len(data)} bytes, expected a binary STL header of {HEAD}")
    count, remarks = _counted(data)
    records = np.frombuffer(data, dtype=FACET, count=count, offset=HEAD)
    values = records["corners"].reshape(-1, 3).astype(np.float64)
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        raise FormatError(f"facet {int(np.argmin(finite)) // 3} has a coordinate that is not a finite number")
    attributes = records["attribute"]
    facts = {"encoding": "binary", "attribute_bytes": bool(attributes.any())}
    faces = np.arange(len(values)).reshape(-1, 3)
    load = partial(_attributes, attributes)
    return patch_document("stl", _Positions(data, values), faces, load, facts=facts, remarks=remarks)


def _counted(data: bytes) -> tuple[int, tuple[str, ...]]:
    """Return how many facets there are, and what the user should know of that."""
    declared = int.from_bytes(data[80:HEAD], "little")
    there, rest = divmod(len(data) - HEAD, FACET.itemsize)
    if there and not rest and (declared in _PLACEHOLDERS or there < declared <= _MOST_MISSED * there):
        found = amount(there, "facet is", "facets are")
        return there, (f"the header declares {declared:,} facets, {found} there",)
    if declared > there or (declared == 0 and there):
        raise FormatError(
            f"the header declares {declared} facets, so {HEAD + FACET.itemsize * declared} bytes are expected, "
            f"but the file has {len(data)}"
        )
    left = len(data) - HEAD - FACET.itemsize * declared
    if 0 < declared < there and _is_facet(data, declared):
        raise FormatError(
            f"the header declares {declared} facets, but {left} bytes follow them that look like further facets"
        )
    return declared, (surplus(left, "byte", "bytes"),) if left and declared else ()


def _is_facet(data: bytes, declared: int) -> bool:
    """Return whether the record behind those declared could be a facet of the same surface."""
    records = np.frombuffer(data, dtype=FACET, count=declared + 1, offset=HEAD)
    corners, normal = records["corners"].astype(np.float64), records["normal"][-1].astype(np.float64)
    if not (np.isfinite(corners).all() and np.isfinite(normal).all()):
        return False
    points = corners[:-1].reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, reach = (low + high) / 2, _REACH * (high - low).max()
    near = bool((np.abs(corners[-1] - middle) <= reach).all())
    return near and len(np.unique(corners[-1], axis=0)) == 3 and bool((np.abs(normal) <= _LONGEST).all())


def _attributes(attributes: NDArray[np.uint16]) -> Attributes:
    return Attributes(other=("facet attributes",) if attributes.any() else ())

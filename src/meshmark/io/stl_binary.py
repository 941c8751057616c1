"""Binary STL: an 80-byte header, a count, and 50 bytes per facet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError, InputError
from meshmark.io.binary_positions import round_to_type
from meshmark.io.document import Attributes
from meshmark.io.patch_document import PatchDocument, patch_document
from meshmark.io.stl_normals import facet_normals, stale_facets
from meshmark.mesh import FloatArray

__all__ = ["FACET", "HEAD", "parse_binary_stl"]

HEAD = 84
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
        records = np.frombuffer(out, dtype=FACET, offset=HEAD)
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
    count = int.from_bytes(data[80:84], "little")
    if len(data) != HEAD + FACET.itemsize * count:
        raise FormatError(
            f"the header declares {count} facets, so {HEAD + FACET.itemsize * count} bytes are expected, "
            f"but the file has {len(data)}"
        )
    records = np.frombuffer(data, dtype=FACET, offset=HEAD)
    values = records["corners"].reshape(-1, 3).astype(np.float64)
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        raise FormatError(f"facet {int(np.argmin(finite)) // 3} has a coordinate that is not a finite number")
    attributes = records["attribute"]
    facts = {"encoding": "binary", "attribute_bytes": bool(attributes.any())}
    faces = np.arange(len(values)).reshape(-1, 3)
    load = partial(_attributes, attributes)
    return patch_document("stl", _Positions(data, values), faces, load, facts)


def _attributes(attributes: NDArray[np.uint16]) -> Attributes:
    return Attributes(other=("facet attributes",) if attributes.any() else ())

"""The mesh every algorithm works on: positions, triangles, and the file they came from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import FloatArray, IntArray
from meshmark.document import Document
from meshmark.errors import InputError

__all__ = ["FloatArray", "IntArray", "Mesh"]

# Squares and cubes of coordinates up to this stay in the range of double precision.
LARGEST = 1e100


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh; never changed in place.

    vertices: (n, 3) float64, finite, in the order of the file, in scene coordinates.
    faces:    (m, 3) int64 indices into `vertices`; polygons of the file arrive triangulated.
    document: the file the mesh was read from, which a save patches; None for a mesh made in memory.

    Raises `InputError` for wrong shapes, coordinates that are not finite, or indices out of range.
    """

    vertices: FloatArray
    faces: IntArray
    document: Document | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise InputError(f"vertices have shape {vertices.shape}, expected (n, 3)")
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise InputError(f"faces have shape {faces.shape}, expected (m, 3)")
        if not np.isfinite(vertices).all():
            row = int(np.argmin(np.isfinite(vertices).all(axis=1)))
            raise InputError(f"vertex {row} has a coordinate that is not finite, expected finite numbers")
        if vertices.size and max(vertices.max(), -vertices.min()) > LARGEST:
            row = int(np.argmax((np.abs(vertices) > LARGEST).any(axis=1)))
            raise InputError(f"vertex {row} has a coordinate beyond {LARGEST:.0e}, whose square overflows")
        if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
            row = int(np.argmax(((faces < 0) | (faces >= len(vertices))).any(axis=1)))
            raise InputError(f"face {row} has a vertex index out of range, expected 0 to {len(vertices) - 1}")
        object.__setattr__(self, "vertices", _frozen(vertices))
        object.__setattr__(self, "faces", _frozen(faces))

    def with_vertices(self, vertices: FloatArray) -> Mesh:
        """Return the same mesh with other positions, shape (n, 3); faces and document are shared."""
        if np.shape(vertices) != self.vertices.shape:
            raise InputError(f"new positions have shape {np.shape(vertices)}, expected {self.vertices.shape}")
        return Mesh(vertices, self.faces, self.document)

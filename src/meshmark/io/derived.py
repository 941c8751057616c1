"""A document for a mesh with other faces than its file: attributes follow the vertices that stayed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from meshmark.io.document import Attributes, Document
from meshmark.io.formats import FORMATS
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["derived"]


@dataclass(frozen=True, eq=False)
class _Derived:
    """See `Document`. base: the file's; origin: (n,) its vertex that each one here takes its attributes from."""

    base: Document
    vertices: FloatArray
    faces: IntArray
    origin: IntArray

    @property
    def format(self) -> str:
        return self.base.format

    def conform(self, vertices: FloatArray) -> FloatArray:
        return vertices.copy()

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        entry = FORMATS[self.format]
        files, _ = entry.convert(vertices, self.faces, self.attributes(), name)
        return files

    def attributes(self) -> Attributes:
        found = self.base.attributes()
        at = self.origin
        if found.seams is not None:  # one of the corners of a vertex speaks for all
            points = found.seams[0]
            first = np.full(len(self.base.vertices), 0)
            first[points[::-1]] = np.arange(len(points))[::-1]
            at = first[at]
        normals, texcoords, colors = found.normals, found.texcoords, found.colors
        return replace(
            found,
            normals=None if normals is None else normals[at],
            texcoords=None if texcoords is None else texcoords[at],
            colors=None if colors is None else colors[at],
            seams=None,
        )

    def summary(self) -> dict[str, Any]:
        return self.base.summary()

    def side_files(self) -> tuple[Path, ...]:
        return ()


def derived(mesh: Mesh, vertices: FloatArray, faces: IntArray, origin: IntArray) -> Mesh:
    """Return a mesh of these vertices (n, 3) and faces (m, 3) that is saved with the attributes of `mesh`'s file.

    origin: (n,) the vertex of `mesh` that each one was; new ones, -1, take the attributes of the nearest.
    """
    if mesh.document is None:
        return Mesh(vertices, faces)
    origin = origin.copy()
    new = origin < 0
    if new.any():
        origin[new] = cKDTree(mesh.vertices).query(vertices[new])[1]
    plain = Mesh(vertices, faces)
    return Mesh(vertices, faces, _Derived(mesh.document, plain.vertices, plain.faces, origin))

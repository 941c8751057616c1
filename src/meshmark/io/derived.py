"""A document for a mesh with other faces than its file: attributes follow the vertices that stayed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from meshmark.document import Attributes, Deviation, Document
from meshmark.geometry.kd_tree import kd_tree
from meshmark.io.formats import FORMATS, Converted
from meshmark.io.gltf.parse import GltfDocument
from meshmark.io.gltf.remesh import can_remesh, remeshed
from meshmark.io.source import SourceFile
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["derived", "losses"]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Derived:
    """See `Document`. base: the file's; origin: (n,) its vertex that each one here takes its attributes from."""

    base: Document
    vertices: FloatArray
    faces: IntArray
    origin: IntArray

    @property
    def format(self) -> str:
        return self.base.format

    @property
    def remarks(self) -> tuple[str, ...]:
        return self.base.remarks

    def conform(self, vertices: FloatArray) -> FloatArray:
        return vertices.copy()

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        if (document := _gltf(self.base)) is not None:
            return remeshed(document, vertices, self.faces, self.origin, name)
        return self._converted(vertices, name)[0]

    def lost(self) -> tuple[str, ...]:
        """Return the names of what the file held that one with other faces does not."""
        if _gltf(self.base) is not None:
            return tuple(f"compression ({name})" for name in self.summary().get("compression", ()))
        seams = () if self.base.attributes().seams is None else ("seams of its texture",)
        return (*self._converted(self.vertices, "model")[1], *seams)

    def _converted(self, vertices: FloatArray, name: str) -> Converted:
        return FORMATS[self.format].convert(vertices, self.faces, self.attributes(), name)

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

    def deviations(self) -> tuple[Deviation, ...]:
        return self.base.deviations()

    def looks(self) -> tuple[str, ...] | None:
        return self.base.looks()

    def side_files(self) -> tuple[Path, ...]:
        return () if _gltf(self.base) is None else self.base.side_files()


def _gltf(base: Document) -> GltfDocument | None:
    """Return the glTF whose primitives can be given other faces, if it is one."""
    inner = base.document if isinstance(base, SourceFile) else base
    return inner if isinstance(inner, GltfDocument) and can_remesh(inner) else None


def losses(mesh: Mesh) -> tuple[str, ...]:
    """Return the names of what the file of a mesh loses by its other faces; none for a mesh as its file has it."""
    document = mesh.document
    inner = document.document if isinstance(document, SourceFile) else document
    return inner.lost() if isinstance(inner, _Derived) else ()


def derived(mesh: Mesh, vertices: FloatArray, faces: IntArray, origin: IntArray) -> Mesh:
    """Return a mesh of these vertices (n, 3) and faces (m, 3) that is saved with the attributes of `mesh`'s file.

    origin: (n,) the vertex of `mesh` that each one was; new ones, -1, take the attributes of the nearest.
    """
    if mesh.document is None:
        return Mesh(vertices, faces)
    origin = origin.copy()
    new = origin < 0
    if new.any():
        origin[new] = kd_tree(mesh.vertices).query(vertices[new])[1]
    plain = Mesh(vertices, faces)
    document = _Derived(base=mesh.document, vertices=plain.vertices, faces=plain.faces, origin=origin)
    if isinstance(mesh.document, SourceFile):
        return Mesh(vertices, faces, SourceFile(path=mesh.document.path, document=document))
    return Mesh(vertices, faces, document)

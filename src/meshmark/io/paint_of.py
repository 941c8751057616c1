"""The paint of a mesh that was read from a file."""

from __future__ import annotations

from meshmark.io.gltf.gltf_paint import gltf_paint
from meshmark.io.gltf.parse import GltfDocument
from meshmark.io.paint import Paint
from meshmark.io.patch_document import PatchDocument
from meshmark.io.source import SourceFile
from meshmark.mesh import Mesh

__all__ = ["paint_of"]


def paint_of(mesh: Mesh) -> Paint | None:
    """Return what the file of a mesh paints its triangles with, in their order: glTF and OBJ.

    None where the file says nothing of it, and for a mesh with other faces than its file.
    """
    document = mesh.document.document if isinstance(mesh.document, SourceFile) else mesh.document
    paint = None
    if isinstance(document, GltfDocument):
        paint = gltf_paint(document.container, document.scene)
    elif isinstance(document, PatchDocument) and document.load_paint is not None:
        paint = document.load_paint()
    return paint if paint is not None and len(paint.image) == len(mesh.faces) else None

"""From a mesh to files of another format: attributes that the target can hold go along, the others are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshmark.document import Attributes
from meshmark.io.formats import Format
from meshmark.io.gzip_data import gzipped
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["converted"]


def converted(mesh: Mesh, entry: Format, name: str) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return the files of a mesh in a format, by name, the model called `name`, and what they cannot hold."""
    attributes = Attributes() if mesh.document is None else mesh.document.attributes()
    attributes, lost = _kept(attributes, entry)
    vertices, faces, attributes = _split_seams(mesh, attributes)
    packed = name.lower().endswith(".gz")
    inner = name[:-3] if packed else name
    files, dropped = entry.convert(vertices, faces, attributes, inner)
    if packed:
        files = {name: gzipped(files.pop(inner)), **files}
    return files, tuple(dict.fromkeys((*lost, *dropped)))


def _kept(attributes: Attributes, entry: Format) -> tuple[Attributes, list[str]]:
    """Return the attributes that the target can hold, and the names of the others."""
    normals, texcoords, colors = attributes.normals, attributes.texcoords, attributes.colors
    lost: list[str] = []
    if normals is not None and "normals" not in entry.keeps:
        normals, lost = None, [*lost, "normals"]
    if texcoords is not None and "texcoords" not in entry.keeps:
        texcoords, lost = None, [*lost, "texture coordinates"]
    if colors is not None and "colors" not in entry.keeps:
        colors, lost = None, [*lost, "vertex colours"]
    return replace(attributes, normals=normals, texcoords=texcoords, colors=colors), lost


def _split_seams(mesh: Mesh, attributes: Attributes) -> tuple[FloatArray, IntArray, Attributes]:
    """Give each corner with attributes of its own a vertex of its own, where there is any to keep."""
    if attributes.seams is None:
        return mesh.vertices, mesh.faces, attributes
    points, faces = attributes.seams
    if attributes.normals is None and attributes.texcoords is None:
        first = np.searchsorted(points, np.arange(len(mesh.vertices)))
        colors = None if attributes.colors is None else attributes.colors[first]
        return mesh.vertices, mesh.faces, replace(attributes, colors=colors, seams=None)
    return mesh.vertices[points], faces, replace(attributes, seams=None)

"""The surface of a mesh, welded once for every mesh and shared by all that ask for it."""

from __future__ import annotations

from weakref import WeakKeyDictionary
from zlib import crc32

import numpy as np

from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import any_coincide, weld
from meshmark.mesh import Mesh

__all__ = ["surface_of", "surface_of_moved"]

_Known = tuple[int, Surface]
# With a checksum of the arrays: who changes an array that a mesh was made of gets a new surface, not the old one.
_KNOWN: WeakKeyDictionary[Mesh, _Known] = WeakKeyDictionary()


def surface_of(mesh: Mesh) -> Surface:
    """Return the surface of a mesh: `weld(mesh)`, computed when it is first asked for.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    Surface
        The same object for as long as the mesh exists.
    """
    known, checksum = _KNOWN.get(mesh), _checksum(mesh)
    if known is not None and known[0] == checksum:
        return known[1]
    return _kept(mesh, checksum, weld(mesh))


def surface_of_moved(mesh: Mesh, before: Mesh) -> Surface:
    """Return the surface of a mesh that differs from another in its positions alone, as `surface_of` does.

    The points are those of `before` as long as vertices of one point stay together and no two points meet, which
    rounding may make them do; otherwise the mesh is welded.

    Parameters
    ----------
    mesh, before : Mesh
        Two meshes with the same faces.

    Returns
    -------
    Surface
        Equal to `weld(mesh)`.
    """
    checksum = _checksum(mesh)
    if mesh.faces is not before.faces and not np.array_equal(mesh.faces, before.faces):
        return surface_of(mesh)
    old = surface_of(before)
    if len(mesh.vertices) != len(before.vertices):
        return surface_of(mesh)
    vertices = points = mesh.vertices + 0.0  # as `weld` does: -0.0 is 0.0
    if len(old.points) != len(vertices):
        points = vertices[old.vertex_of_point]
        if not np.array_equal(points[old.point_of_vertex], vertices):
            return surface_of(mesh)
    if any_coincide(points):
        return surface_of(mesh)
    same = np.array_equal(points, old.points)
    return _kept(mesh, checksum, old if same else old.moved(points))


def _kept(mesh: Mesh, checksum: int, surface: Surface) -> Surface:
    _KNOWN[mesh] = checksum, surface
    return surface


def _checksum(mesh: Mesh) -> int:
    return crc32(mesh.faces.data, crc32(mesh.vertices.data))

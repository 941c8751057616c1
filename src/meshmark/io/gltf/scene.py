"""From glTF's nodes and meshes to placements and triangles.

All nodes of all scenes count; a file without scenes shows all its root nodes, one without nodes each mesh
once. Meshes that no scene reaches, points and lines stay untouched and are no part of the surface, nor is
what a node flattens (scale 0). A skinned mesh stands where its joints put it at rest (`skin.py`). GPU
instances and level-of-detail extensions are not expanded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import Accessor, open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.node_tree import Nodes, open_nodes
from meshmark.io.gltf.schema import Json, integer, objects, reference
from meshmark.io.placement import Affine
from meshmark.mesh import IntArray

__all__ = ["Part", "Primitive", "Scene", "open_scene", "primitives_of"]

_TRIANGLES, _STRIP, _FAN = 4, 5, 6

# A few bytes of nodes or primitives can show a large mesh many times: this bounds the memory that a small file may
# ask for, as most points and triangles. A compressed file, which can hold a large mesh in a few bytes, is read
# within 1 GB.
_MOST, _MOST_COMPRESSED = (30_000_000, 60_000_000), (2_500_000, 5_000_000)


@dataclass(frozen=True, eq=False, kw_only=True)
class Primitive:
    """Triangles (m, 3) of one primitive, as rows of its POSITION accessor, and its attributes by name.

    item: the JSON object.
    """

    position: int
    faces: IntArray
    attributes: dict[str, int]
    item: Json


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """One POSITION accessor of a mesh as one node shows it."""

    accessor: int
    mesh: int
    affine: Affine


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """All parts in order, the triangles over them, and what was opened on the way."""

    parts: tuple[Part, ...]
    faces: IntArray
    accessors: dict[int, Accessor]
    primitives: dict[int, tuple[Primitive, ...]]
    nodes: Nodes


def open_scene(container: Container, *, compressed: bool = False) -> Scene:
    """Walk the scenes and gather the surface.

    compressed: the container was unpacked from a compressed file, of which less is read. Raises `FormatError` where
    the scene shows more than is read, or no triangle.
    """
    most = _MOST_COMPRESSED if compressed else _MOST
    nodes, accessors = open_nodes(container), dict[int, Accessor]()
    primitives: dict[int, tuple[Primitive, ...]] = {}
    parts, faces, rows, total = [], list[IntArray](), 0, 0
    for showing in nodes.showings:
        mesh, affine = showing.mesh, showing.affine
        if not affine.is_usable:
            continue
        if mesh not in primitives:
            if _triangles(container, mesh) + total > most[1]:
                raise _too_large(most)
            primitives[mesh] = primitives_of(container, mesh, accessors)
        starts: dict[int, int] = {}
        for item in primitives[mesh]:
            if item.position not in starts:
                starts[item.position] = rows
                parts.append(Part(accessor=item.position, mesh=mesh, affine=affine))
                rows += accessors[item.position].count
            total += len(item.faces)
            if rows > most[0] or total > most[1]:
                raise _too_large(most)
            start = starts[item.position]
            faces.append(item.faces + start if start else item.faces)
    if not total:
        raise FormatError(f"{container.path.name} shows no triangles in any scene")
    whole = faces[0] if len(faces) == 1 else np.concatenate(faces)
    return Scene(parts=tuple(parts), faces=whole, accessors=accessors, primitives=primitives, nodes=nodes)


def _too_large(most: tuple[int, int]) -> FormatError:
    read = f"more than {most[0]:,} points or {most[1]:,} triangles"
    if most == _MOST_COMPRESSED:
        return FormatError(
            f"the scene of a compressed file shows {read}: uncompress it with another tool first"
        )
    return FormatError(f"the scene shows {read}")


def _triangles(container: Container, mesh: int) -> int:
    """Return how many triangles a mesh has by the counts of its accessors, before any of them is read."""
    accessors, total = container.tables["accessors"], 0
    for number, item in enumerate(objects(container.tables["meshes"][mesh], "primitives")):
        where = f"mesh {mesh}, primitive {number}"
        index = reference(item, "indices", where, accessors)
        index = _attributes(container, item, where).get("POSITION") if index is None else index
        if index is not None:
            corners = integer(accessors[index], "count", f"accessor {index}")
            mode = integer(item, "mode", where, _TRIANGLES)
            total += corners // 3 if mode == _TRIANGLES else corners if mode in (_STRIP, _FAN) else 0
    return total


def primitives_of(container: Container, mesh: int, accessors: dict[int, Accessor]) -> tuple[Primitive, ...]:
    """Return the triangle primitives of a mesh; accessors that are opened are added to the table."""
    found = []
    for number, item in enumerate(objects(container.tables["meshes"][mesh], "primitives")):
        where = f"mesh {mesh}, primitive {number}"
        mode = integer(item, "mode", where, _TRIANGLES)
        attributes = _attributes(container, item, where)
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
            continue
        position = attributes["POSITION"]
        if position not in accessors:
            accessors[position] = _open_positions(container, position)
        found.append(
            Primitive(
                position=position,
                faces=_faces(container, item, where, mode, accessors[position]),
                attributes=attributes,
                item=item,
            )
        )
    return tuple(found)


def _attributes(container: Container, item: Json, where: str) -> dict[str, int]:
    table = item.get("attributes", {})
    if not isinstance(table, dict):
        raise FormatError(f"{where}: 'attributes' is not an object")
    accessors = container.tables["accessors"]
    found = {name: reference(table, name, where, accessors) for name in table}
    return {name: index for name, index in found.items() if index is not None}


def _open_positions(container: Container, index: int) -> Accessor:
    accessor = open_accessor(container, index)
    used = container.tree.get("extensionsUsed", [])
    quantised = isinstance(used, list) and "KHR_mesh_quantization" in used and accessor.dtype.itemsize < 4
    if accessor.width != 3 or not (accessor.dtype.kind == "f" or quantised):
        raise FormatError(
            f"accessor {index} holds positions as {accessor.width} x {accessor.dtype.name}, expected 3 x "
            "float32 (or 8 or 16 bit integers with KHR_mesh_quantization)"
        )
    return accessor


def _faces(container: Container, item: Json, where: str, mode: int, positions: Accessor) -> IntArray:
    index = reference(item, "indices", where, container.tables["accessors"])
    if index is None:
        corners = np.arange(positions.count, dtype=np.int64)
    else:
        accessor = open_accessor(container, index)
        if accessor.width != 1 or accessor.dtype.kind != "u" or accessor.normalized:
            raise FormatError(f"accessor {index} holds the indices of {where}, expected unsigned scalars")
        corners = accessor.raw(container.blob)[:, 0].astype(np.int64)
    if corners.max() >= positions.count:
        row = int(np.argmax(corners >= positions.count))
        raise FormatError(
            f"{where}: index {row} is {corners[row]}, expected an index below {positions.count}"
        )
    if len(corners) < 3 or (mode == _TRIANGLES and len(corners) % 3):
        raise FormatError(f"{where} has {len(corners)} corners, which make no whole triangles")
    if mode == _TRIANGLES:
        return corners.reshape(-1, 3)
    if mode == _FAN:
        return np.stack([corners[1:-1], corners[2:], np.full(len(corners) - 2, corners[0])], axis=1)
    odd = np.arange(len(corners) - 2) % 2 == 1
    second, third = np.where(odd, corners[2:], corners[1:-1]), np.where(odd, corners[1:-1], corners[2:])
    return np.stack([corners[:-2], second, third], axis=1)

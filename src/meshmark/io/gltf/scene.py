"""From glTF's nodes and meshes to placements and triangles.

All nodes of all scenes count; a file without scenes shows all its root nodes, one without nodes each mesh
once. Meshes that no scene reaches, points and lines stay untouched and are no part of the surface, nor is
what a node flattens (scale 0). A skinned mesh stands where its joints put it at rest (`skin.py`). GPU
instances and level-of-detail extensions are not expanded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import Accessor, open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.schema import Json, integer, numbers, objects, reference, references
from meshmark.io.gltf.skin import skin_placement
from meshmark.io.placement import Affine
from meshmark.mesh import IntArray

__all__ = ["Part", "Primitive", "Scene", "open_scene", "primitives_of"]

_TRIANGLES, _STRIP, _FAN = 4, 5, 6

# A few bytes of nodes or primitives can show a large mesh many times: this bounds the memory that a small file may
# ask for, as most points and triangles. A compressed file, which can hold a large mesh in a few bytes, is read
# within 1 GB.
_MOST, _MOST_COMPRESSED = (30_000_000, 60_000_000), (2_500_000, 5_000_000)

# Exporters that multiply 32-bit matrices leave a last row that is 0 0 0 1 but for rounding.
_AFFINE_WITHIN = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class Primitive:
    """Triangles (m, 3) of one primitive, as rows of its POSITION accessor, and its attributes by name."""

    position: int
    faces: IntArray
    attributes: dict[str, int]


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


def open_scene(container: Container, *, compressed: bool = False) -> Scene:
    """Walk the scenes and gather the surface.

    compressed: the container was unpacked from a compressed file, of which less is read. Raises `FormatError` where
    the scene shows more than is read, or no triangle.
    """
    most = _MOST_COMPRESSED if compressed else _MOST
    accessors: dict[int, Accessor] = {}
    primitives: dict[int, tuple[Primitive, ...]] = {}
    parts, faces, rows, total = [], list[IntArray](), 0, 0
    for mesh, affine in _showings(container):
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
    return Scene(parts=tuple(parts), faces=whole, accessors=accessors, primitives=primitives)


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


def _showings(container: Container) -> list[tuple[int, Affine]]:
    """Return (mesh, map to the scene) of each node with a mesh, parents first, in the order of the file."""
    nodes, meshes = container.tables["nodes"], container.tables["meshes"]
    if not nodes and not container.tables["scenes"]:
        return [(mesh, Affine.identity()) for mesh in range(len(meshes))]
    children = [references(node, "children", f"node {i}", nodes) for i, node in enumerate(nodes)]
    parent: dict[int, int] = {}
    for number, below in enumerate(children):
        for child in below:
            if child in parent:
                raise FormatError(f"node {child} is a child twice, of {parent[child]} and of {number}")
            parent[child] = number
    roots = _roots(container, parent)
    # With at most one parent each and starting from nodes without one, the walk meets no node twice.
    stack = [(root, Affine.identity()) for root in reversed(roots)]
    found: list[tuple[int, Affine, int | None]] = []
    world: dict[int, Affine] = {}
    while stack:
        number, above = stack.pop()
        node, where = nodes[number], f"node {number}"
        affine = above.after(_local(node, where))
        mesh = reference(node, "mesh", where, meshes)
        if not (np.isfinite(affine.linear).all() and np.isfinite(affine.offset).all()):
            raise FormatError(f"{where}: its transform is beyond the range of floating point numbers")
        world[number] = affine
        if mesh is not None:
            found.append((mesh, affine, reference(node, "skin", where, container.tables["skins"])))
        stack += [(child, affine) for child in reversed(children[number])]
    return [
        (mesh, affine if skin is None else skin_placement(container, skin, world))
        for mesh, affine, skin in found
    ]


def _roots(container: Container, parent: dict[int, int]) -> list[int]:
    nodes = container.tables["nodes"]
    if "scenes" not in container.tree:
        return [number for number in range(len(nodes)) if number not in parent]
    roots: list[int] = []
    for number, scene in enumerate(container.tables["scenes"]):
        roots += references(scene, "nodes", f"scene {number}", nodes)
    for root in roots:
        if root in parent:
            raise FormatError(
                f"a scene lists node {root}, a child of node {parent[root]}, expected root nodes"
            )
    return list(dict.fromkeys(roots))


def _local(node: Json, where: str) -> Affine:
    """Return a node's own map, from its matrix (column by column) or translation, rotation, scale.

    What breaks the specification is read as three.js and Blender read it: beside a matrix the other three do not
    count, the last row of a matrix is taken as 0 0 0 1 where it is that but for rounding, and a rotation of length
    zero turns nothing. A rotation of any other length is made a unit one, as Blender and trimesh do.
    """
    parts: dict[str, list[Any]] = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
    if "matrix" in node:
        matrix = np.array(numbers(node, "matrix", where, [0.0] * 16)).reshape(4, 4).T
        if (np.abs(matrix[3] - [0, 0, 0, 1]) > _AFFINE_WITHIN).any():
            raise FormatError(f"{where}: its matrix is not affine, expected the last row 0 0 0 1")
        return Affine(matrix[:3, :3], matrix[:3, 3])
    move, (x, y, z, w), scale = (numbers(node, key, where, default) for key, default in parts.items())
    length = math.hypot(x, y, z, w)
    if not math.isfinite(length):
        raise FormatError(f"{where}: its rotation is beyond the range of floating point numbers")
    x, y, z, w = (x / length, y / length, z / length, w / length) if length > 0 else (0.0, 0.0, 0.0, 1.0)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return Affine(turn * np.array(scale), np.array(move, dtype=np.float64))

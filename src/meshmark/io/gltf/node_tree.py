"""glTF's nodes: which of them show a mesh, and under which map."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.schema import Json, numbers, reference, references
from meshmark.io.gltf.skin import skin_placement
from meshmark.io.placement import Affine

__all__ = ["Nodes", "Showing", "open_nodes", "scene_roots"]

# Exporters that multiply 32-bit matrices leave a last row that is 0 0 0 1 but for rounding.
_AFFINE_WITHIN = 1e-3


@dataclass(frozen=True, kw_only=True)
class Showing:
    """A mesh as one node shows it; node: None in a file without nodes. skin: that moves it, or None."""

    node: int | None
    mesh: int
    skin: int | None
    affine: Affine


@dataclass(frozen=True, kw_only=True)
class Nodes:
    """All nodes of all scenes.

    showings: parents first, in the order of the file. world: the map to the scene of every node shown. parent: of
    each node that has one.
    """

    showings: tuple[Showing, ...]
    world: dict[int, Affine]
    parent: dict[int, int]

    def above(self, nodes: Iterable[int | None]) -> frozenset[int]:
        """Return these nodes and all above them."""
        found: set[int] = set()
        for node in nodes:
            while node is not None and node not in found:
                found.add(node)
                node = self.parent.get(node)
        return frozenset(found)

    def below(self, tops: frozenset[int]) -> frozenset[int]:
        """Return which nodes shown are these, or lie below one of them."""
        found: set[int] = set()
        for node in self.world:  # parents first
            if node in tops or self.parent.get(node) in found:
                found.add(node)
        return frozenset(found)


def open_nodes(container: Container) -> Nodes:
    """Walk the nodes of all scenes. Raises `FormatError` where they are no forest, or a map is not affine."""
    nodes, meshes = container.tables["nodes"], container.tables["meshes"]
    if not nodes and not container.tables["scenes"]:
        plain = Affine.identity()
        every = (Showing(node=None, mesh=mesh, skin=None, affine=plain) for mesh in range(len(meshes)))
        return Nodes(showings=tuple(every), world={}, parent={})
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
    found: list[Showing] = []
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
            skin = reference(node, "skin", where, container.tables["skins"])
            found.append(Showing(node=number, mesh=mesh, skin=skin, affine=affine))
        stack += [(child, affine) for child in reversed(children[number])]
    placed = (
        item if item.skin is None else replace(item, affine=skin_placement(container, item.skin, world))
        for item in found
    )
    return Nodes(showings=tuple(placed), world=world, parent=parent)


def _roots(container: Container, parent: dict[int, int]) -> list[int]:
    nodes = container.tables["nodes"]
    if "scenes" not in container.tree:
        return [number for number in range(len(nodes)) if number not in parent]
    roots: list[int] = []
    for number in range(len(container.tables["scenes"])):
        roots += scene_roots(container, number)
    for root in roots:
        if root in parent:
            raise FormatError(
                f"a scene lists node {root}, a child of node {parent[root]}, expected root nodes"
            )
    return list(dict.fromkeys(roots))


def scene_roots(container: Container, number: int) -> list[int]:
    """Return the root nodes of one scene."""
    return references(
        container.tables["scenes"][number], "nodes", f"scene {number}", container.tables["nodes"]
    )


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

"""What a glTF holds beside positions: the part other formats can keep, and the names of the rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from meshmark.document import Attributes
from meshmark.io.colors import rgba
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.scene import Part, Scene
from meshmark.io.gltf.schema import objects
from meshmark.mesh import FloatArray

__all__ = ["gltf_attributes", "gltf_summary"]

_KEPT = {"POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"}
_TABLES = ("materials", "textures", "animations", "skins", "cameras")


def gltf_attributes(container: Container, scene: Scene) -> Attributes:
    """Return per-vertex data in scene coordinates, and what else is there."""
    normals = _gather(container, scene, "NORMAL", (3,), _normals)
    texcoords = _gather(container, scene, "TEXCOORD_0", (2,), lambda values, _: values * [1, -1] + [0, 1])
    colors = _gather(container, scene, "COLOR_0", (3, 4), _colors)
    return Attributes(
        normals=normals,
        texcoords=texcoords,
        colors=None if colors is None else colors.astype(np.uint8),
        other=_other(container, scene),
    )


def _gather(
    container: Container,
    scene: Scene,
    name: str,
    widths: tuple[int, ...],
    convert: Callable[[FloatArray, Part], FloatArray],
) -> FloatArray | None:
    """Return one attribute for all rows, or None unless every part has exactly one."""
    blocks = []
    for part in scene.parts:
        sources = {
            item.attributes.get(name)
            for item in scene.primitives[part.mesh]
            if item.position == part.accessor
        }
        source = sources.pop() if len(sources) == 1 else None
        if source is None:
            return None
        accessor = open_accessor(container, source)
        if accessor.width not in widths or accessor.count != scene.accessors[part.accessor].count:
            return None
        blocks.append(convert(accessor.values(container.blob), part))
    return np.concatenate(blocks)


def _normals(values: FloatArray, part: Part) -> FloatArray:
    # Normals turn with the inverse transpose, so that they stay square to the surface under any map.
    turned = values @ np.linalg.inv(part.affine.linear)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return turned / np.where(lengths > 0, lengths, 1)


def _colors(values: FloatArray, _: Part) -> FloatArray:
    return rgba(np.nan_to_num(values), unit=True).astype(np.float64)


def _other(container: Container, scene: Scene) -> tuple[str, ...]:
    tree, tables = container.tree, container.tables
    found = [name for name in _TABLES if tables[name]]
    meshes = tables["meshes"]
    primitives = [item for mesh in meshes for item in objects(mesh, "primitives")]
    attributes = {name for group in scene.primitives.values() for item in group for name in item.attributes}
    checks = {
        "morph targets": any("targets" in item for item in primitives),
        "further vertex attributes": bool(attributes - _KEPT),
        "points and lines": any(item.get("mode", 4) not in (4, 5, 6) for item in primitives),
        "separate meshes": len(scene.parts) > 1,
        "extensions": bool(tree.get("extensionsUsed")),
    }
    return (*found, *(name for name, present in checks.items() if present))


def gltf_summary(container: Container, scene: Scene) -> dict[str, Any]:
    """Return what `meshmark info` prints about a glTF."""
    tree = container.tree
    kinds = sorted({scene.accessors[part.accessor].dtype.name for part in scene.parts})
    names = ("scenes", "nodes", "meshes", "materials", "textures", "images", "skins", "animations")
    return {
        "encoding": "binary" if container.format == "glb" else "JSON",
        "precision": ", ".join(kinds),
        "parts_shown": len(scene.parts),
        **{name: len(container.tables[name]) for name in names},
        "extensions": tree.get("extensionsUsed", []),
        "generator": tree["asset"].get("generator", ""),
    }

"""glTF 2.0, as .gltf and .glb: a save patches positions into the original bytes and nothing else.

Specification: Khronos glTF 2.0.1, with KHR_mesh_quantization. A file with compressed data (Draco, meshopt) is
decoded first (`unpack`), and a save with moved positions writes it uncompressed, see
docs/decisions/0002-compressed-gltf.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes, Deviation
from meshmark.errors import FormatError, InputError
from meshmark.geometry.extent import diagonal
from meshmark.io.gltf.attributes import gltf_attributes, gltf_summary
from meshmark.io.gltf.container import Container, open_glb, open_gltf
from meshmark.io.gltf.patch import rebuild, referenced_files, referenced_images
from meshmark.io.gltf.points import Points, open_points
from meshmark.io.gltf.scene import Scene, open_scene
from meshmark.io.gltf.unpack import compressions, unpacked
from meshmark.io.gltf.uses import check_uses
from meshmark.io.image_magic import HEAD, is_image
from meshmark.io.inside import head_inside, is_inside
from meshmark.io.placement import Placement, place, pull_back
from meshmark.mesh import FloatArray, IntArray

__all__ = ["GltfDocument", "parse_glb", "parse_gltf"]


@dataclass(frozen=True, eq=False, kw_only=True)
class GltfDocument:
    """A glTF file; the `Document` protocol says what its methods promise.

    `scene` says which vertices there are; `patch` how files beside a .gltf are named.
    compressed: the file as it was read, where the container holds it without its compression; else None.
    """

    container: Container
    scene: Scene
    points: Points
    placements: tuple[Placement, ...]
    vertices: FloatArray
    faces: IntArray
    compressed: Container | None = None
    remarks: tuple[str, ...] = ()

    @property
    def format(self) -> str:
        """Return "glb" or "gltf"."""
        return self.container.format

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the positions (n, 3) that reading the written file would give, to the last bit."""
        target, moved = self._pulled(vertices)
        return place(self.points.snapped(target, moved), self.placements)

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the files to write: the model, and of a .gltf the buffers beside it.

        Raises `FormatError` where moved positions share their bytes with other data, `InputError` where
        a position cannot be stored.
        """
        target, moved = self._pulled(vertices)
        if self.compressed is not None and not moved.any():
            names = {item.name for item in self.compressed.segments if item.kind == "file"}
            return rebuild(self.compressed, self.compressed.blob, name, names)
        blob = self.container.blob
        if moved.any():
            check_uses(self.container, self.points, moved)
            blob = self.points.written(target, moved, blob)
        return rebuild(self.container, blob, name, self._held())

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep."""
        return gltf_attributes(self.container, self.scene)

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints."""
        names = () if self.compressed is None else compressions(self.compressed)
        return {**gltf_summary(self.compressed or self.container, self.scene), "compression": list(names)}

    def deviations(self) -> tuple[Deviation, ...]:
        """Return in which ways a viewer shows something else than the surface. Raises `FormatError`."""
        from meshmark.io.gltf.deviations import gltf_deviations

        return gltf_deviations(self.container, self.scene, diagonal(self.vertices, self.faces) or 1.0)

    def looks(self) -> tuple[str, ...] | None:
        """Return what the surface is painted with, a digest for each kind of material. Raises `FormatError`."""
        from meshmark.io.gltf.looks import gltf_looks

        return gltf_looks(self.container, self.scene)

    def side_files(self) -> tuple[Path, ...]:
        """Return the existing images, and buffers without positions, beside the model; images by what they hold."""
        held, folder = self._held(), self.container.path.parent
        listed = referenced_files(self.container)
        if self.compressed is not None:  # its buffers are still the input's, whatever a save writes
            listed = list(dict.fromkeys([*listed, *referenced_files(self.compressed)]))
        images = referenced_images(self.container)
        names = [name for name in listed if name not in held]
        return tuple(
            folder / name
            for name in names
            if (is_image(head_inside(folder, name, HEAD)) if name in images else is_inside(folder, name))
        )

    def _held(self) -> set[str]:
        """Return the names of the buffers beside the model that hold positions of the surface."""
        files = [item for item in self.container.segments if item.kind == "file"]
        address = self.points.address
        spans = {item.name: (address >= item.start) & (address < item.start + item.size) for item in files}
        return {name for name, inside in spans.items() if inside.any()}

    def _pulled(self, vertices: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        if np.shape(vertices) != self.vertices.shape:
            raise InputError(f"new positions have shape {np.shape(vertices)}, expected {self.vertices.shape}")
        return pull_back(self.points.values, self.placements, self.vertices, vertices)


def parse_glb(data: bytes, path: Path) -> GltfDocument:
    """Read a binary glTF. Raises `FormatError`."""
    return _parse(open_glb(data, path))


def parse_gltf(data: bytes, path: Path) -> GltfDocument:
    """Read a .gltf and the buffers beside it or inside it. Raises `FormatError`."""
    return _parse(open_gltf(data, path))


def _parse(read: Container) -> GltfDocument:
    container = unpacked(read)
    scene = open_scene(container, compressed=container is not read)
    used = dict.fromkeys(part.accessor for part in scene.parts)
    points = open_points(container.blob, [scene.accessors[index] for index in used])
    placements = tuple(Placement(points.slots[part.accessor], part.affine) for part in scene.parts)
    vertices = place(points.values, placements)
    if not np.isfinite(vertices).all():
        raise FormatError(f"{container.path.name}: its node transforms take positions beyond any range")
    vertices.flags.writeable = False
    scene.faces.flags.writeable = False
    compressed = None if container is read else read
    return GltfDocument(
        container=container,
        scene=scene,
        points=points,
        placements=placements,
        vertices=vertices,
        faces=scene.faces,
        compressed=compressed,
    )

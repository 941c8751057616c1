"""In which ways viewers of a glTF show something else than the surface that is read from it.

The surface is that of all scenes, with morph targets at rest, skins at rest, materials that are seen, and no
animation. What else a file may do is named here, and measured where it can be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from meshmark.document import KINDS, Deviation
from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.animations import animated
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.deformation import morph_displacement, skin_displacement
from meshmark.io.gltf.hidden_faces import hidden_faces, material_of
from meshmark.io.gltf.node_tree import Nodes, Showing, open_nodes, scene_roots
from meshmark.io.gltf.scene import Primitive, Scene
from meshmark.io.gltf.schema import Json, integer, objects, reference

__all__ = ["gltf_deviations"]

_POINTS, _LINES, _LOOP, _STRIP = 0, 1, 2, 3
# What a file cannot say in numbers of its own, and amounts without bound.
_WHOLE, _MOST, _MANY = 1.0, 8.0, 1000.0


def gltf_deviations(container: Container, scene: Scene, diagonal: float) -> tuple[Deviation, ...]:
    """Return the deviations of a file, in the order of `KINDS`.

    Where something that is looked at breaks the format viewers answer in different ways, and the amount is the
    largest there is.

    Parameters
    ----------
    container : Container
        Uncompressed.
    scene : Scene
        That was read from it.
    diagonal : float
        Of the surface, above 0.

    Returns
    -------
    tuple of Deviation
    """
    look = _Look(container=container, scene=scene, diagonal=diagonal)
    amounts = {kind: _amount(measure) for kind, measure in look.measures.items()}
    for kind in animated(container, look.nodes):
        amounts[kind] = _WHOLE
    return tuple(Deviation(kind=kind, amount=amounts[kind]) for kind in KINDS if amounts.get(kind, 0.0) > 0.0)


def _amount(measure: Callable[[], float]) -> float:
    try:
        return float(np.nan_to_num(measure(), nan=_MOST, posinf=_MOST).clip(0.0, _MOST))
    except FormatError:
        return _MOST


@dataclass(frozen=True, eq=False, kw_only=True)
class _Look:
    container: Container
    scene: Scene
    diagonal: float

    @property
    def measures(self) -> dict[str, Callable[[], float]]:
        return {
            "morph_weights": self._morphed,
            "skin": self._skinned,
            "scene": lambda: self._share(self._outside),
            "instancing": self._instances,
            "lines": self._lines,
            "points": self._points,
            "hidden_material": self._hidden,
            "hidden_node": lambda: self._share(self._invisible),
            "levels_of_detail": self._levels,
        }

    @cached_property
    def nodes(self) -> Nodes:
        return open_nodes(self.container)

    @cached_property
    def _total(self) -> int:
        return len(self.scene.faces)

    def _surface(self) -> Iterator[tuple[Showing, Primitive]]:
        for showing in self.nodes.showings:
            if showing.affine.is_usable:
                for primitive in self.scene.primitives[showing.mesh]:
                    yield showing, primitive

    def _morphed(self) -> float:
        found = (morph_displacement(self.container, *each) for each in self._surface())
        return max(found, default=0.0) / self.diagonal

    def _skinned(self) -> float:
        found = (
            skin_displacement(self.container, self.nodes, showing, primitive, self._stored(primitive))
            for showing, primitive in self._surface()
        )
        return max(found, default=0.0) / self.diagonal

    def _stored(self, primitive: Primitive) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return self.scene.accessors[primitive.position].values(self.container.blob)

    def _share(self, missing: Callable[[Showing], bool]) -> float:
        """Return the share of the faces in showings that are not seen."""
        gone = sum(len(primitive.faces) for showing, primitive in self._surface() if missing(showing))
        return gone / self._total

    @cached_property
    def _default(self) -> frozenset[int]:
        """Return the roots of the scene that viewers show first: that the file names, else the first one."""
        scenes = self.container.tables["scenes"]
        if not scenes:
            return frozenset()
        number = reference(self.container.tree, "scene", "the file", scenes)
        return frozenset(scene_roots(self.container, number or 0))

    def _outside(self, showing: Showing) -> bool:
        return not self._default.intersection(self.nodes.lineage(showing.node))

    def _invisible(self, showing: Showing) -> bool:
        above = (self.container.tables["nodes"][number] for number in self.nodes.lineage(showing.node))
        return any(_extension(node, "KHR_node_visibility").get("visible") is False for node in above)

    def _instances(self) -> float:
        total = 0
        for node in self.container.tables["nodes"]:
            attributes = _extension(node, "EXT_mesh_gpu_instancing").get("attributes")
            for index in list(attributes.values())[:1] if isinstance(attributes, dict) else ():
                accessor = {"index": index}
                number = reference(accessor, "index", "instances", self.container.tables["accessors"])
                total += open_accessor(self.container, number or 0).count
        return total / _MANY

    def _others(self, *modes: int) -> Iterator[tuple[Showing, Json]]:
        """Yield the primitives of some modes, of each mesh that is shown."""
        for showing in self.nodes.showings:
            for item in objects(self.container.tables["meshes"][showing.mesh], "primitives"):
                if integer(item, "mode", "primitive", 4) in modes:
                    yield showing, item

    def _points(self) -> float:
        return sum(len(self._corners(item)) for _, item in self._others(_POINTS)) / _MANY

    def _lines(self) -> float:
        """Return the length of all lines, over the diagonal."""
        total = 0.0
        for showing, item in self._others(_LINES, _LOOP, _STRIP):
            mode, corners = integer(item, "mode", "primitive"), showing.affine(self._corners(item))
            if mode == _LOOP:
                corners = np.concatenate([corners, corners[:1]])
            steps = (
                corners[1::2] - corners[: len(corners) // 2 * 2 : 2]
                if mode == _LINES
                else np.diff(corners, axis=0)
            )
            total += float(np.sqrt((steps**2).sum(axis=1)).sum())
        return total / self.diagonal

    def _corners(self, item: Json) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Return the points (k, 3) of a primitive in the order in which it names them."""
        accessors = self.container.tables["accessors"]
        attributes = item.get("attributes")
        position = reference(
            attributes if isinstance(attributes, dict) else {}, "POSITION", "primitive", accessors
        )
        if position is None:
            return np.empty((0, 3))
        points = open_accessor(self.container, position).values(self.container.blob)
        index = reference(item, "indices", "primitive", accessors)
        if index is None:
            return points
        rows = open_accessor(self.container, index).raw(self.container.blob)[:, 0].astype(np.int64)
        if rows.max(initial=0) >= len(points):
            raise FormatError(f"accessor {index} names point {rows.max()} of {len(points)}")
        return points[rows]

    def _hidden(self) -> float:
        gone = 0
        for _, primitive in self._surface():
            rows = self.scene.accessors[primitive.position].count
            gone += int(hidden_faces(self.container, primitive, rows).sum())
        return gone / self._total

    def _levels(self) -> float:
        holders = [*self.container.tables["nodes"]]
        holders += [material_of(self.container, primitive) for _, primitive in self._surface()]
        return _WHOLE if any(_extension(holder, "MSFT_lod") for holder in holders) else 0.0


def _extension(item: Json, name: str) -> Json:
    found = item.get("extensions")
    inner = found.get(name) if isinstance(found, dict) else None
    return inner if isinstance(inner, dict) else {}

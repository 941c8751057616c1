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
from meshmark.io.gltf.base_colour import material_of
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.deformation import morph_displacement, skin_displacement
from meshmark.io.gltf.hidden_faces import hidden_faces
from meshmark.io.gltf.node_tree import Nodes, Showing, scene_roots
from meshmark.io.gltf.scene import Primitive, Scene
from meshmark.io.gltf.schema import Json, integer, objects, reference
from meshmark.io.gltf.views import extension

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

    @property
    def nodes(self) -> Nodes:
        return self.scene.nodes

    @cached_property
    def _total(self) -> int:
        return len(self.scene.faces)

    @cached_property
    def _surface(self) -> tuple[tuple[Showing, Primitive], ...]:
        usable = (showing for showing in self.nodes.showings if showing.affine.is_usable)
        return tuple((each, primitive) for each in usable for primitive in self.scene.primitives[each.mesh])

    def _morphed(self) -> float:
        found = (morph_displacement(self.container, *each) for each in self._surface)
        return max(found, default=0.0) / self.diagonal

    def _skinned(self) -> float:
        found = (
            skin_displacement(self.container, self.nodes, showing, primitive, self._stored(primitive))
            for showing, primitive in self._surface
        )
        return max(found, default=0.0) / self.diagonal

    def _stored(self, primitive: Primitive) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return self.scene.accessors[primitive.position].values(self.container.blob)

    def _share(self, missing: Callable[[Showing], bool]) -> float:
        """Return the share of the faces in showings that are not seen."""
        gone = sum(len(primitive.faces) for showing, primitive in self._surface if missing(showing))
        return gone / self._total

    @cached_property
    def _seen_first(self) -> frozenset[int]:
        return self.nodes.below(self._default)

    @cached_property
    def _switched_off(self) -> frozenset[int]:
        off = (
            number
            for number, node in enumerate(self.container.tables["nodes"])
            if (extension(node, "KHR_node_visibility") or {}).get("visible") is False
        )
        return self.nodes.below(frozenset(off))

    @cached_property
    def _default(self) -> frozenset[int]:
        """Return the roots of the scene that viewers show first: that the file names, else the first one."""
        scenes = self.container.tables["scenes"]
        if not scenes:
            return frozenset()
        number = reference(self.container.tree, "scene", "the file", scenes)
        return frozenset(scene_roots(self.container, number or 0))

    def _outside(self, showing: Showing) -> bool:
        return showing.node not in self._seen_first

    def _invisible(self, showing: Showing) -> bool:
        return showing.node in self._switched_off

    def _instances(self) -> float:
        total = 0
        for node in self.container.tables["nodes"]:
            attributes = (extension(node, "EXT_mesh_gpu_instancing") or {}).get("attributes")
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
        gone: dict[Primitive, int] = {}  # however often a mesh is shown, what it hides is the same
        for _, primitive in self._surface:
            if primitive not in gone:
                rows = self.scene.accessors[primitive.position].count
                gone[primitive] = int(hidden_faces(self.container, primitive, rows).sum())
        return sum(gone[primitive] for _, primitive in self._surface) / self._total

    def _levels(self) -> float:
        holders = [*self.container.tables["nodes"]]
        holders += [material_of(self.container, primitive) for _, primitive in self._surface]
        return _WHOLE if any(extension(holder, "MSFT_lod") for holder in holders) else 0.0

"""Primitives under KHR_draco_mesh_compression: what their streams hold, and where it goes once it is decoded.

Source: the extension's specification in the Khronos glTF registry.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import COMPONENTS, WIDTHS, component
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.schema import Json, integer, objects, reference
from meshmark.io.gltf.views import Views, extension, forget

__all__ = ["DRACO", "Draco", "draco_primitives", "place_draco", "views_named"]

DRACO = "KHR_draco_mesh_compression"
_TRIANGLES = 4
_CODES = {np.dtype(name): code for code, name in COMPONENTS.items()}

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Draco:
    """A compressed primitive: the bufferView of its stream, the stream's id of each attribute by name.

    claimed: how many bytes its accessors say there are.
    """

    where: str
    mesh: int
    primitive: int
    view: int
    attributes: dict[str, int]
    claimed: int


def draco_primitives(container: Container) -> list[Draco]:
    """Return the compressed primitives of all meshes. Raises `FormatError` where one does not name its stream."""
    found = []
    for mesh, entry in enumerate(container.tables["meshes"]):
        for number, item in enumerate(objects(entry, "primitives", f"mesh {mesh}")):
            where = f"mesh {mesh}, primitive {number}"
            record = extension(item, DRACO)
            if record is None:
                continue
            view = reference(record, "bufferView", where, container.tables["bufferViews"])
            if view is None:
                raise FormatError(f"{where} names no bufferView for its {DRACO}")
            ids = record.get("attributes", {})
            if not isinstance(ids, dict) or not isinstance(item.get("attributes"), dict):
                raise FormatError(f"{where}: 'attributes' is not an object")
            attributes = {name: integer(ids, name, where) for name in ids if name in item["attributes"]}
            claimed = _claimed(container, item, attributes, where)
            found.append(
                Draco(
                    where=where,
                    mesh=mesh,
                    primitive=number,
                    view=view,
                    attributes=attributes,
                    claimed=claimed,
                )
            )
    return found


def _claimed(container: Container, item: Json, attributes: dict[str, int], where: str) -> int:
    total = 0
    for table, name in [(item["attributes"], name) for name in attributes] + [(item, "indices")]:
        index = reference(table, name, where, container.tables["accessors"])
        if index is not None:
            record = container.tables["accessors"][index]
            width = WIDTHS.get(str(record.get("type")), 16)
            total += integer(record, "count", f"accessor {index}") * width * component(record, where).itemsize
    return total


def place_draco(tree: Json, views: Views, items: list[Draco], decoded: Mapping[int, Arrays]) -> None:
    """Give the primitives in `tree`, a copy that may be changed, what was decoded from each stream.

    decoded: by bufferView, "faces" (m, 3) and the attributes under their ids. The counts of accessors become those
    of the stream, as viewers take them. Raises `FormatError` where the two do not fit otherwise.
    """
    packed = {(item.mesh, item.primitive) for item in items}
    placer = _Placer(tree, views, packed)
    before = views_named(tree)
    for item in items:
        primitive, arrays = tree["meshes"][item.mesh]["primitives"][item.primitive], decoded[item.view]
        faces = arrays["faces"].reshape(-1)
        counts = {len(arrays[str(number)]) for number in item.attributes.values()}
        if not len(faces) or len(counts) > 1 or faces.max() >= min(counts, default=1 << 32):
            raise FormatError(f"{item.where}: its Draco stream holds no triangles over its attributes")
        placer.indices(primitive, item, faces)
        for name, number in item.attributes.items():
            index = placer.attribute(primitive["attributes"][name], item, number, arrays[str(number)])
            primitive["attributes"][name] = index
        forget(primitive, DRACO)
        if primitive.get("mode", _TRIANGLES) != _TRIANGLES:
            primitive["mode"] = _TRIANGLES  # a stream holds single triangles, whatever it was made from
    # What a primitive had for viewers without Draco is an older copy of the surface: nothing needs it any more.
    for view in before - views_named(tree):
        if view < len(views.records) and view not in views.contents:
            views.fill(view, np.zeros(4, np.uint8))


def views_named(part: Any) -> set[int]:
    """Return the bufferViews that anything in a part of the JSON names."""
    if isinstance(part, list):
        return set().union(*map(views_named, part))
    if not isinstance(part, dict):
        return set()
    own = {value for key, value in part.items() if key == "bufferView" and isinstance(value, int)}
    return own.union(*map(views_named, part.values()))


class _Placer:
    """Hands decoded arrays to accessors; one that others use too is copied: two streams, or a plain primitive."""

    def __init__(self, tree: Json, views: Views, packed: set[tuple[int, int]]) -> None:
        self.accessors: list[Json] = tree.setdefault("accessors", [])
        self.views = views
        plain = {
            index
            for mesh, entry in enumerate(tree.get("meshes", []))
            for number, item in enumerate(entry.get("primitives", []))
            if (mesh, number) not in packed
            for index in _accessors_of(item)
        }
        self.owner: dict[int, tuple[int, str]] = dict.fromkeys(plain, (-1, ""))
        self.copies: dict[tuple[int, int, str], int] = {}
        self.held: dict[tuple[int, str, str], int] = {}

    def indices(self, primitive: Json, item: Draco, faces: NDArray[Any]) -> None:
        if "indices" not in primitive:
            self.accessors.append({"componentType": 5125, "count": len(faces), "type": "SCALAR"})
            primitive["indices"] = len(self.accessors) - 1
        index, record = self._own(int(primitive["indices"]), item, "faces")
        primitive["indices"] = index
        dtype = component(record, item.where)
        if dtype.kind != "u" or faces.max() >= np.iinfo(dtype).max:  # the highest number is reserved
            dtype = np.dtype("<u2") if faces.max() < 65535 else np.dtype("<u4")
        key = (item.view, "faces", dtype.str)
        if key not in self.held and item.view not in self.views.contents:
            self.views.fill_indices(item.view, faces.astype(dtype))
            self.held[key] = item.view
        elif key not in self.held:
            self.held[key] = self.views.add(faces.astype(dtype))
        self._point(record, self.held[key], len(faces))
        record["componentType"] = _CODES[dtype]

    def attribute(self, index: int, item: Draco, number: int, rows: NDArray[Any]) -> int:
        """Return the accessor, that at `index` or a copy of it, with the rows (n, width) of attribute `number`."""
        index, record = self._own(int(index), item, str(number))
        dtype = component(record, item.where)
        if WIDTHS.get(str(record.get("type"))) != rows.shape[1]:
            raise FormatError(
                f"accessor {index} is a {record.get('type')}, its Draco stream has {rows.shape[1]} columns"
            )
        stored = _as_type(rows, dtype)
        if stored is None:
            raise FormatError(
                f"accessor {index} holds {dtype.name}, its Draco stream other numbers ({rows.dtype.name})"
            )
        key = (item.view, str(number), dtype.str)
        if key not in self.held:
            self.held[key] = self.views.add(stored)
        self._point(record, self.held[key], len(rows))
        return index

    def _own(self, index: int, item: Draco, part: str) -> tuple[int, Json]:
        source = (item.view, part)
        if self.owner.setdefault(index, source) != source:
            key = (index, *source)
            if key not in self.copies:
                self.accessors.append(dict(self.accessors[index]))
                self.copies[key] = len(self.accessors) - 1
            index = self.copies[key]
        return index, self.accessors[index]

    @staticmethod
    def _point(record: Json, view: int, count: int) -> None:
        record.pop("byteOffset", None)
        record.pop("sparse", None)
        record.update(bufferView=view, count=count)


def _accessors_of(item: Json) -> list[int]:
    table = item.get("attributes")
    named = [item.get("indices"), *(table.values() if isinstance(table, dict) else ())]
    return [int(index) for index in named if isinstance(index, (int, float)) and index == int(index)]


def _as_type(rows: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any] | None:
    """Return the numbers in another type, None where it does not hold them."""
    if dtype.kind == "i" and rows.dtype.kind == "u":  # the library gives signed integers as unsigned ones
        rows = rows.view(f"<i{rows.dtype.itemsize}")
    with np.errstate(invalid="ignore", over="ignore"):
        stored = rows.astype(dtype)
    return (
        stored if np.array_equal(stored.astype(rows.dtype), rows, equal_nan=rows.dtype.kind == "f") else None
    )

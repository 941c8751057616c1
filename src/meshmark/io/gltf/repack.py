"""A plain glTF compressed again with KHR_draco_mesh_compression.

Positions are stored on a grid of 24 bits, about what 32-bit floats hold; all other attributes without any loss. The
points come in the encoder's order, each with all its attributes; where something beside the stream counts them
(morph targets, attributes that Draco does not hold) or the encoder would leave some out, they stay in their order,
which compresses less. All primitives of a mesh share one grid, so that the seams between them stay closed.
"""

from __future__ import annotations

import copy
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container, open_glb, open_gltf
from meshmark.io.gltf.draco import DRACO, views_named
from meshmark.io.gltf.schema import Json
from meshmark.io.gltf.views import Views, with_one_buffer

__all__ = ["check_encoders", "repacked"]

_BITS, _LEVEL = 24, 7
_TRIANGLES = 4
_HELD = ("f4", "u1", "u2", "u4")

Rows = NDArray[Any]


def check_encoders(names: Sequence[str]) -> None:
    """Raise `InputError` unless all these extensions can be written."""
    for name in names:
        if name != DRACO:
            raise InputError(
                f"meshmark has no encoder for {name}: leave --recompress out, and compress the marked file with "
                "another tool"
            )


def repacked(files: Mapping[str, bytes], name: str, format_: str) -> dict[str, bytes]:
    """Return the files of a plain glTF, the model being `name`, with its triangles compressed by Draco."""
    if format_ == "glb":
        container = open_glb(files[name], Path(name))
    else:
        with tempfile.TemporaryDirectory() as folder:
            for other, data in files.items():
                place = Path(folder) / other
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(data)
            container = open_gltf(files[name], Path(folder) / name)
    tree = copy.deepcopy(container.tree)
    before = views_named(tree)
    streams = _Packer(container, tree).streams()
    views = Views(container, tree)
    _store(views, streams, sorted(before - views_named(tree)))
    for key in ("extensionsUsed", "extensionsRequired"):
        tree[key] = list(dict.fromkeys([*tree.get(key, []), DRACO]))
    packed = with_one_buffer(container, tree, views)
    beside = {item.name: packed.blob.tobytes() for item in packed.segments if item.kind == "file"}
    return {name: packed.raw, **beside}


def _store(views: Views, streams: list[tuple[list[Json], bytes]], free: list[int]) -> None:
    """Put each stream into a bufferView, one that nothing names any more where there is one; drop such others."""
    for records, stream in streams:
        if not free:
            free.append(views.add(np.zeros(4, np.uint8)))
        view = free.pop(0)
        views.fill(view, np.frombuffer(stream, np.uint8))
        for key in ("target", "byteStride"):
            views.records[view].pop(key, None)
        for record in records:
            record["bufferView"] = view
    for view in reversed(free):
        if view == len(views.records) - 1:
            views.records.pop()
        else:
            views.fill(view, np.zeros(4, np.uint8))


class _Packer:
    """Compresses the primitives of a tree, which is changed; primitives of the same accessors share a stream."""

    def __init__(self, container: Container, tree: Json) -> None:
        self.container, self.accessors = container, tree["accessors"]
        self.items: list[Json] = []
        self.grids: list[tuple[Rows, float]] = []
        for mesh in tree["meshes"]:
            items = [
                item
                for item in mesh.get("primitives", [])
                if item.get("mode", _TRIANGLES) == _TRIANGLES and "indices" in item
            ]
            self.items += items
            self.grids += [self._grid(items)] * len(items)
        keys = [_key(item) for item in self.items]
        # How many different sets of accessors, and how much else in the file, name an accessor.
        self.users = Counter(number for key in set(keys) for number in key[1])
        inside = Counter(number for key in keys for number in key[1])
        for number, count in _accessors_named(tree).items():
            self.users[number] += count - inside[number]

    def streams(self) -> list[tuple[list[Json], bytes]]:
        """Return each stream with the extension objects that are to name its bufferView."""
        done: dict[tuple[Any, ...], tuple[list[Json], bytes, Json]] = {}
        for item, grid in zip(self.items, self.grids, strict=True):
            key = _key(item)
            if key not in done:
                stream, changed = self._compressed(item, grid)
                done[key] = ([], stream, changed)
            records, _, changed = done[key]
            record: Json = {"attributes": dict(changed["ids"])}
            records.append(record)
            item["indices"], item["attributes"] = changed["indices"], dict(changed["attributes"])
            item.setdefault("extensions", {})[DRACO] = record
        return [(records, stream) for records, stream, _ in done.values()]

    def _grid(self, items: list[Json]) -> tuple[Rows, float]:
        """Return the origin and the size of a cube around all positions of these primitives."""
        rows = [
            open_accessor(self.container, item["attributes"]["POSITION"]).raw(self.container.blob)
            for item in items
        ]
        if not rows:
            return np.zeros(3), 1.0
        low, high = (
            np.min([row.min(axis=0) for row in rows], axis=0),
            np.max([row.max(axis=0) for row in rows], axis=0),
        )
        return low.astype(np.float64), float((high - low).max()) or 1.0

    def _compressed(self, item: Json, grid: tuple[Rows, float]) -> tuple[bytes, Json]:
        blob = self.container.blob
        rows = {
            name: open_accessor(self.container, number).raw(blob)
            for name, number in item["attributes"].items()
        }
        faces = open_accessor(self.container, item["indices"]).raw(blob).reshape(-1, 3)
        positions = rows.pop("POSITION")
        if positions.dtype != np.dtype("<f4"):
            raise InputError("Draco cannot hold this file's integer positions: leave --recompress out")
        held = {name: value for name, value in rows.items() if value.dtype.str[1:] in _HELD}
        ordered = len(held) < len(rows) or "targets" in item
        stream, ids, mesh = _encoded((positions, faces, grid), held, ordered)
        attributes = dict(item["attributes"])
        for name in ids:
            attributes[name], record = self._own(attributes[name])
            record["count"] = len(mesh.points)
            if name == "POSITION":
                stored = np.asarray(mesh.points, np.float32)
                record["min"], record["max"] = stored.min(axis=0).tolist(), stored.max(axis=0).tolist()
        indices, record = self._own(item["indices"])
        record["count"] = 3 * len(mesh.faces)
        return stream, {"ids": ids, "attributes": attributes, "indices": indices}

    def _own(self, number: int) -> tuple[int, Json]:
        """Return an accessor without bytes: the one at `number`, or a copy where others need its bytes."""
        record = self.accessors[number]
        if self.users[number] > 1:
            record = dict(record)
            self.accessors.append(record)
            number = len(self.accessors) - 1
        for key in ("bufferView", "byteOffset", "sparse"):
            record.pop(key, None)
        return number, record


def _key(item: Json) -> tuple[Any, ...]:
    """Return what two primitives must share to share a stream."""
    numbers = (item["indices"], *(item["attributes"][name] for name in sorted(item["attributes"])))
    return tuple(sorted(item["attributes"])), numbers


def _accessors_named(tree: Json) -> Counter[int]:
    """Count the places of the file that name each accessor."""
    found: Counter[int] = Counter()
    for mesh in tree["meshes"]:
        for item in mesh.get("primitives", []):
            named = [item.get("attributes", {}), *item.get("targets", [])]
            found.update([number for table in named for number in table.values()])
            found.update([item["indices"]] if "indices" in item else [])
    for animation in tree.get("animations", []):
        for sampler in animation.get("samplers", []):
            found.update([sampler[key] for key in ("input", "output") if key in sampler])
    found.update(
        [skin["inverseBindMatrices"] for skin in tree.get("skins", []) if "inverseBindMatrices" in skin]
    )
    return found


def _encoded(
    surface: tuple[Rows, Rows, tuple[Rows, float]], held: Mapping[str, Rows], ordered: bool
) -> tuple[bytes, dict[str, int], Any]:
    """Return a stream, the id in it of each attribute by name, and what the stream decodes to."""
    import DracoPy

    positions, faces, (origin, size) = surface
    numbered = {name: number for number, name in enumerate(held)}
    stream = DracoPy.encode(
        np.ascontiguousarray(positions),
        faces.astype(np.uint32),
        quantization_bits=_BITS,
        compression_level=_LEVEL,
        quantization_origin=origin,
        quantization_range=size,
        preserve_order=ordered,
        generic_attributes={numbered[name]: np.ascontiguousarray(rows) for name, rows in held.items()}
        or None,
    )
    mesh = DracoPy.decode(stream)
    same = len(mesh.points) == len(positions) and len(mesh.faces) == len(faces)
    for name, rows in held.items():
        same = same and _as_bag(
            mesh.get_attribute_by_unique_id(numbered[name])["data"].astype(rows.dtype), ordered
        ) == (_as_bag(rows, ordered))
    if same:
        place = next(entry["unique_id"] for entry in mesh.attributes if entry["attribute_type"] == 0)
        return stream, {"POSITION": place, **numbered}, mesh
    if ordered:
        raise InputError("the Draco encoder does not keep all data of this file: leave --recompress out")
    return _encoded(surface, held, True)


def _as_bag(rows: Rows, ordered: bool) -> bytes:
    """Return the bytes of rows, sorted unless their order counts."""
    flat = np.ascontiguousarray(rows)
    whole = flat.view(f"V{flat.shape[1] * flat.itemsize}").reshape(-1)
    return (whole if ordered else np.sort(whole)).tobytes()

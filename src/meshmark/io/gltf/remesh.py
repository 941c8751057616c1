"""A glTF whose surface got other faces: primitives keep their materials, and vertices all their attributes.

New accessors lie behind the old bytes, which stay as they are; so do nodes, skins, animations and images.
"""

from __future__ import annotations

import base64
import copy
import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.geometry.kd_tree import kd_tree
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.parse import GltfDocument
from meshmark.io.gltf.points import Kind
from meshmark.mesh import FloatArray, IntArray

__all__ = ["can_remesh", "remeshed"]

_TRIANGLES, _ROWS, _INDICES = 4, 34962, 34963
# Stands for the buffer with the new rows until its number is known.
_NEW = -1
_CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


@dataclass(frozen=True, eq=False, kw_only=True)
class _Piece:
    """One primitive as one node shows it: its rows among all vertices start at `start`; faces: which of all."""

    part: int
    number: int
    start: int
    faces: slice


@dataclass(frozen=True, eq=False, kw_only=True)
class _Surface:
    """The new vertices (n, 3), the new faces (k, 3) of one primitive, and `origin` (n,) as in `remeshed`."""

    vertices: FloatArray
    faces: IntArray
    origin: IntArray


def can_remesh(document: GltfDocument) -> bool:
    """Return whether every primitive is shown once, as triangles of its own accessors."""
    shown = [part.accessor for part in document.scene.parts]
    items = [
        item
        for mesh in document.container.tables["meshes"]
        for item in mesh.get("primitives", [])
        if item.get("mode", _TRIANGLES) == _TRIANGLES and "POSITION" in item.get("attributes", {})
    ]
    held = sum(len(group) for group in document.scene.primitives.values())
    return len(set(shown)) == len(shown) and held == len(items)


def remeshed(
    document: GltfDocument, vertices: FloatArray, faces: IntArray, origin: IntArray, name: str
) -> dict[str, bytes]:
    """Return the files of the document with these vertices (n, 3) and faces (m, 3).

    origin: (n,) the document's vertex that each one takes its attributes from. A face belongs to the primitive that
    had it, a new one to that of its first corner. Raises `InputError` unless `can_remesh`.
    """
    if not can_remesh(document):
        raise InputError(
            f"{document.container.path.name} shows a mesh twice, or as strips, expected triangles"
        )
    tree = copy.deepcopy(document.container.tree)
    pieces = _pieces(document)
    owner = _owners(document, pieces, origin[faces])
    writer = _Writer(tree, bytearray())
    for index, piece in enumerate(pieces):
        surface = _Surface(vertices=vertices, faces=faces[owner == index], origin=origin)
        _write(document, piece, writer, surface)
    return _files(document, tree, bytes(writer.data), name)


@dataclass(frozen=True, eq=False)
class _Writer:
    """Collects rows of new accessors."""

    tree: dict[str, Any]
    data: bytearray

    def add(self, rows: NDArray[Any], like: dict[str, Any], target: int) -> int:
        """Return the number of a new accessor that holds rows (n, width), described as `like` it."""
        row = rows.shape[1] * rows.dtype.itemsize
        stride = row if target == _INDICES else row + -row % 4
        padded = np.zeros((len(rows), stride), np.uint8)
        padded[:, :row] = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), row)
        view = {"buffer": _NEW, "byteOffset": len(self.data), "byteLength": padded.size, "target": target}
        if target == _ROWS:
            view["byteStride"] = stride
        self.data.extend(padded.tobytes())
        self.data.extend(bytes(-len(self.data) % 4))
        self.tree.setdefault("bufferViews", []).append(view)
        item: dict[str, Any] = {key: like[key] for key in ("normalized", "name") if key in like}
        item |= {
            "bufferView": len(self.tree["bufferViews"]) - 1,
            "componentType": _CODES[rows.dtype.str[1:]],
            "count": len(rows),
            "type": _TYPES[rows.shape[1]],
        }
        self.tree["accessors"].append(item)
        return len(self.tree["accessors"]) - 1


def _pieces(document: GltfDocument) -> list[_Piece]:
    pieces, row, face = [], 0, 0
    for number, part in enumerate(document.scene.parts):
        for place, item in enumerate(document.scene.primitives[part.mesh]):
            if item.position == part.accessor:
                pieces.append(
                    _Piece(part=number, number=place, start=row, faces=slice(face, face + len(item.faces)))
                )
                face += len(item.faces)
        row += document.scene.accessors[part.accessor].count
    return pieces


def _owners(document: GltfDocument, pieces: list[_Piece], corners: IntArray) -> IntArray:
    """Return (m,): the piece of each face, given its corners (m, 3) as vertices of the document."""
    old = np.empty(len(document.faces), np.int64)
    of_vertex = np.full(len(document.vertices), -1)
    for index, piece in enumerate(pieces):
        old[piece.faces] = index
        of_vertex[document.faces[piece.faces]] = index
    if (of_vertex < 0).any() and len(pieces):  # vertices that no face uses
        lone = of_vertex < 0
        of_vertex[lone] = of_vertex[~lone][
            kd_tree(document.vertices[~lone]).query(document.vertices[lone])[1]
        ]
    owner = of_vertex[corners[:, 0]]
    keys = _keys(np.concatenate([document.faces, corners]))
    order = np.argsort(keys[: len(old)], kind="stable")
    place = np.minimum(np.searchsorted(keys[: len(old)][order], keys[len(old) :]), len(old) - 1)
    same = keys[: len(old)][order[place]] == keys[len(old) :]
    return np.where(same, old[order[place]], owner)


def _keys(faces: IntArray) -> IntArray:
    """Return (m,) numbers that are equal for faces of the same three vertices."""
    return np.asarray(np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)[1]).ravel()


def _write(document: GltfDocument, piece: _Piece, writer: _Writer, surface: _Surface) -> None:
    """Give a primitive its new faces, and rows for their corners."""
    tree, vertices, faces, origin = writer.tree, surface.vertices, surface.faces, surface.origin
    part = document.scene.parts[piece.part]
    item = document.scene.primitives[part.mesh][piece.number]
    entry = _entry(tree, part.mesh, item.attributes)
    accessor = document.scene.accessors[item.position]
    first, count = piece.start, accessor.count
    if not len(faces):  # glTF knows no empty primitive
        writer_faces, rows, source = np.zeros((1, 3), np.int64), np.array([-1]), np.array([0])
    else:
        rows, at = np.unique(faces, return_inverse=True)
        writer_faces, source = at.reshape(-1, 3), origin[rows] - first
        foreign = (source < 0) | (source >= count)
        if foreign.any():  # a corner from another primitive: it looks like the nearest one here
            near = kd_tree(document.vertices[first : first + count])
            source[foreign] = near.query(vertices[rows[foreign]])[1]
    raw = accessor.raw(document.container.blob)[source]
    if len(faces):
        places = vertices[rows]
        moved = (document.vertices[first + source] != places).any(axis=1)
        local = (places[moved] - part.affine.offset) @ np.linalg.inv(part.affine.linear).T
        raw = raw.copy()
        raw[moved] = Kind(accessor.dtype, accessor.normalized).encode(local)
    position = writer.add(raw, tree["accessors"][item.position], _ROWS)
    tree["accessors"][position] |= {"min": raw.min(axis=0).tolist(), "max": raw.max(axis=0).tolist()}
    for group in (entry["attributes"], *entry.get("targets", [])):
        for label, number in group.items():
            if group is entry["attributes"] and label == "POSITION":
                group[label] = position
                continue
            other = open_accessor(document.container, number)
            new = writer.add(other.raw(document.container.blob)[source], tree["accessors"][number], _ROWS)
            if label == "POSITION":  # of a morph target: bounds are required
                held = other.raw(document.container.blob)[source]
                tree["accessors"][new] |= {"min": held.min(axis=0).tolist(), "max": held.max(axis=0).tolist()}
            group[label] = new
    entry["indices"] = writer.add(writer_faces.reshape(-1, 1).astype("<u4"), {}, _INDICES)
    entry["mode"] = _TRIANGLES


def _entry(tree: dict[str, Any], mesh: int, attributes: dict[str, int]) -> dict[str, Any]:
    """Return the first primitive of a mesh that still has these attributes."""
    found: dict[str, Any] = next(
        item for item in tree["meshes"][mesh]["primitives"] if item.get("attributes") == attributes
    )
    return found


def _files(document: GltfDocument, tree: dict[str, Any], data: bytes, name: str) -> dict[str, bytes]:
    container = document.container
    new = [view for view in tree["bufferViews"] if view["buffer"] == _NEW]
    if container.format == "gltf":
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        tree.setdefault("buffers", []).append({"byteLength": len(data), "uri": uri})
        for view in new:
            view["buffer"] = len(tree["buffers"]) - 1
        return {name: json.dumps(tree, indent=1).encode(), **_held(document)}
    chunk = container.raw[slice(*container.chunk_span)] if container.chunk_span else b""
    chunk += bytes(-len(chunk) % 4)
    for view in new:
        view["buffer"] = 0
        view["byteOffset"] += len(chunk)
    tree["buffers"][0]["byteLength"] = len(chunk) + len(data)
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(chunk) + len(data), 0x004E4942) + chunk + data
    return {name: struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body}


def _held(document: GltfDocument) -> dict[str, bytes]:
    """Return the buffers beside a .gltf, as they are."""
    blob = document.container.blob
    files = [item for item in document.container.segments if item.kind == "file"]
    return {item.name: blob[item.start : item.start + item.size].tobytes() for item in files}

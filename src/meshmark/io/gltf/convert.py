"""Fresh glTF 2.0 files, valid by Khronos' validator: one mesh, one node, every buffer inside the file."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_glb", "convert_gltf"]

_FLOAT, _BYTE, _SHORT, _INT = 5126, 5121, 5123, 5125
_VERTEX_BUFFER, _INDEX_BUFFER = 34962, 34963

# 32-bit floats resolve about 1e-7 of their size: farther from the origin than this many diagonals, the
# positions are stored about their centre and a node's translation, which has all digits, moves them back.
_FAR = 4.0


@dataclass(kw_only=True)
class _Writer:
    """Collects arrays into one buffer, each with its bufferView and accessor."""

    blob: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def add(self, rows: NDArray[Any], code: int, kind: str, **more: Any) -> int:
        target = _INDEX_BUFFER if kind == "SCALAR" else _VERTEX_BUFFER
        data = np.ascontiguousarray(rows).tobytes()
        self.views.append(
            {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), "target": target}
        )
        self.blob += data + b"\0" * (-len(data) % 4)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": code,
                "count": len(rows),
                "type": kind,
                **more,
            }
        )
        return len(self.accessors) - 1


def convert_glb(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return a new binary glTF, and the names of what it does not keep.

    Positions are 32-bit floats; normals, texture coordinates and colours are kept where given.
    """
    tree, blob, dropped = _built(vertices, faces, attributes, name)
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    head = b"glTF" + struct.pack("<III4s", 2, total, len(text), b"JSON")
    return {name: b"".join([head, text, struct.pack("<I4s", len(blob), b"BIN\0"), blob])}, dropped


def convert_gltf(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return a new .gltf with its buffer inside as base64, and the names of what it does not keep.

    One file, so that nothing is left behind when it is moved; otherwise as `convert_glb`.
    """
    tree, blob, dropped = _built(vertices, faces, attributes, name)
    tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    return {name: json.dumps(tree, indent=1).encode()}, dropped


def _built(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, Any], bytes, tuple[str, ...]]:
    if not len(faces):
        raise InputError(f"cannot write {name}: glTF holds no mesh without triangles")
    writer, dropped = _Writer(), list(attributes.other)
    stored, centre = _centred(vertices, name)
    bounds = {"min": stored.min(axis=0).tolist(), "max": stored.max(axis=0).tolist()}
    table = {"POSITION": writer.add(stored, _FLOAT, "VEC3", **bounds)}
    if attributes.normals is not None:
        unit = _unit(attributes.normals)
        if unit is None:
            dropped.append("normals, as some have no direction")
        else:
            table["NORMAL"] = writer.add(unit, _FLOAT, "VEC3")
    if attributes.texcoords is not None:
        # glTF counts v from the upper edge of the image.
        with np.errstate(over="ignore"):
            flipped = (attributes.texcoords * [1, -1] + [0, 1]).astype("<f4")
        if np.isfinite(flipped).all():
            table["TEXCOORD_0"] = writer.add(flipped, _FLOAT, "VEC2")
        else:
            dropped.append("texture coordinates, as some are not finite numbers")
    if attributes.colors is not None:
        table["COLOR_0"] = writer.add(attributes.colors, _BYTE, "VEC4", normalized=True)
    # The highest number of each type is reserved, as a restart mark.
    short = len(vertices) <= 65535
    corners = faces.ravel().astype("<u2" if short else "<u4")
    indices = writer.add(corners, _SHORT if short else _INT, "SCALAR")
    node: dict[str, Any] = {"mesh": 0, "name": PurePosixPath(name).stem}
    if centre.any():
        node["translation"] = centre.tolist()
    tree = {
        "asset": {"version": "2.0", "generator": "meshmark"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"primitives": [{"attributes": table, "indices": indices}]}],
        "accessors": writer.accessors,
        "bufferViews": writer.views,
        "buffers": [{"byteLength": len(writer.blob)}],
    }
    return tree, bytes(writer.blob), tuple(dropped)


def _centred(vertices: FloatArray, name: str) -> tuple[NDArray[np.float32], FloatArray]:
    """Return float32 positions and the translation to add to them."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    far = np.abs(vertices).max() > _FAR * np.linalg.norm(high - low)
    centre = low + (high - low) / 2 if far else np.zeros(3)
    with np.errstate(over="ignore"):
        stored = (vertices - centre).astype("<f4")
    if not np.isfinite(stored).all():
        raise InputError(f"cannot write {name}: a coordinate is beyond the range of 32-bit floats")
    return stored, centre


def _unit(normals: FloatArray) -> NDArray[np.float32] | None:
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    if not (np.isfinite(lengths).all() and (lengths > 0).all()):
        return None
    return np.asarray(normals / lengths, dtype="<f4")

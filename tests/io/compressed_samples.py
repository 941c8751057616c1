"""Compressed glTF files made for tests: by Draco's own encoder, and by a small meshopt writer here."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import DracoPy
import numpy as np

from meshmark.io.gltf.accessor import WIDTHS, component
from tests.io.gltf_samples import Sample

# Streams that meshoptimizer 1.3 (npm) encoded, with the SHA-256 (16 digits) of what it decodes them to:
# [mode, filter, count, stride, base64, digest].
STREAMS: list[list[Any]] = json.loads((Path(__file__).with_name("meshopt_streams.json")).read_text())


def bytes_of(stream: list[Any]) -> bytes:
    return base64.b64decode(stream[4])


def meshopt_rows(rows: np.ndarray) -> bytes:
    """Return rows (n, stride) of uint8 as a stream of version 0, every byte in full."""
    count, stride = rows.shape
    before = np.vstack([np.zeros((1, stride), np.uint8), rows[:-1]])
    deltas = (rows - before).astype(np.int8).astype(np.int16)
    zigzag = np.where(deltas < 0, -2 * deltas - 1, 2 * deltas).astype(np.uint8)
    block = min(8192 // stride // 16 * 16, 256)
    out = bytearray(b"\xa0")
    for start in range(0, count, block):
        part = zigzag[start : start + block]
        groups = -(-len(part) // 16)
        for column in range(stride):
            out += b"\xff" * -(-groups // 4) + part[:, column].tobytes() + bytes(-len(part) % 16)
    return bytes(out) + bytes(max(32, stride))


def meshopt_triangles(indices: np.ndarray) -> bytes:
    """Return indices as a stream in which every corner is given by its difference to the last."""
    out, last = bytearray(), 0
    for triangle in indices.reshape(-1, 3):
        out += b"\xff"
        for index in map(int, triangle):
            step = (index - last) & 0xFFFFFFFF  # as in the reference, where a step may wrap around
            value = (step << 1 & 0xFFFFFFFF) ^ (0xFFFFFFFF if step >> 31 else 0)
            last = index
            while value > 127:
                out.append(value & 127 | 128)
                value >>= 7
            out.append(value)
    return b"\xe1" + b"\xff" * (len(indices) // 3) + bytes(out) + bytes(16)


def with_meshopt(sample: Sample, extension: str = "EXT_meshopt_compression") -> Sample:
    """Return a sample whose vertex attributes and 16-bit indices are compressed, over a buffer without bytes."""
    tree, blob = json.loads(json.dumps(sample.tree)), bytes(sample.blob)
    out = Sample(tree)
    fallback = 0
    for number, view in enumerate(tree["bufferViews"]):
        data = blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        items = [item for item in tree["accessors"] if item.get("bufferView") == number]
        target = view.get("target")
        item = items[0] if items else {}
        indices = target == 34963 and item["componentType"] == 5123 and len(data) % 6 == 0
        row = WIDTHS[item["type"]] * component(item, "").itemsize if item else 0
        stride = 2 if indices else view.get("byteStride", row)
        start = len(out.blob)
        if not indices and (target != 34962 or not stride or len(data) % stride or stride % 4):
            out.blob += data + bytes(-len(data) % 4)
            view |= {"byteOffset": start}
            continue
        rows = np.frombuffer(data, np.uint8).reshape(-1, stride)
        stream = meshopt_triangles(rows.view("<u2").ravel()) if indices else meshopt_rows(rows)
        record = {"buffer": 0, "byteOffset": start, "byteLength": len(stream), "byteStride": stride}
        record |= {"count": len(rows), "mode": "TRIANGLES" if indices else "ATTRIBUTES"}
        out.blob += stream + bytes(-len(stream) % 4)
        view |= {"buffer": 1, "byteOffset": fallback, "extensions": {extension: record}}
        if not indices:
            view["byteStride"] = stride
        fallback += len(data) + -len(data) % 4
    tree["buffers"] = [
        {"byteLength": len(out.blob)},
        {"byteLength": fallback, "extensions": {extension: {"fallback": True}}},
    ]
    for key in ("extensionsUsed", "extensionsRequired"):
        tree[key] = [*tree.get(key, []), extension]
    return out


def draco_grid(side: int = 12, bits: int = 14) -> Sample:
    """Return a curved sheet of side x side points with normals and joints, compressed with Draco."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    points = np.stack([x, y, 3 * np.sin(x / 4) * np.cos(y / 5)], 2).reshape(-1, 3).astype("<f4")
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        [[first, first + 1, first + side], [first + 1, first + side + 1, first + side]], axis=1
    ).T
    normals = np.tile(np.array([0.6, 0, 0.8], "f4"), (len(points), 1))
    joints = np.tile(np.arange(4, dtype="u1"), (len(points), 1))
    stream = DracoPy.encode(
        points, faces.astype("u4"), quantization_bits=bits, generic_attributes={3: normals, 5: joints}
    )
    mesh = DracoPy.decode(stream)
    place = next(item["unique_id"] for item in mesh.attributes if item["attribute_type"] == 0)
    sample = Sample()
    view = sample.view(stream)
    count = len(mesh.points)
    limits = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    position = sample.put("accessors", componentType=5126, count=count, type="VEC3", **limits)
    normal = sample.put("accessors", componentType=5126, count=count, type="VEC3")
    joint = sample.put("accessors", componentType=5121, count=count, type="VEC4")
    indices = sample.put("accessors", componentType=5123, count=3 * len(faces), type="SCALAR")
    ids = {"POSITION": place, "NORMAL": 3, "_JOINT": 5}
    record = {"bufferView": view, "attributes": ids}
    attributes = {"NORMAL": normal, "_JOINT": joint}
    mesh_number = sample.mesh(
        position, indices, attributes=attributes, extensions={"KHR_draco_mesh_compression": record}
    )
    sample.node(mesh=mesh_number, name="sheet", extras={"kept": [1, 2]})
    for key in ("extensionsUsed", "extensionsRequired"):
        sample.tree[key] = ["KHR_draco_mesh_compression"]
    return sample

"""glTF files made for tests, each with a record of which bytes of its buffer are positions."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

_CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype="f4") * [1.1, 0.7, 2.3]
CUBE_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)
UNIT = np.array([[0, 0, 1.0]] * 8)


@dataclass
class Sample:
    """A growing glTF; `positions` lists the byte spans of positions in the buffer."""

    tree: dict[str, Any] = field(default_factory=dict)
    blob: bytearray = field(default_factory=bytearray)
    positions: list[tuple[int, int]] = field(default_factory=list)
    meshes: list[Any] = field(default_factory=list)

    def put(self, key: str, **item: Any) -> int:
        self.tree.setdefault(key, []).append(item)
        return len(self.tree[key]) - 1

    def view(self, data: bytes, **more: Any) -> int:
        self.blob += b"\0" * (-len(self.blob) % 4)
        view = self.put("bufferViews", buffer=0, byteOffset=len(self.blob), byteLength=len(data), **more)
        self.blob += data
        return view

    def array(self, rows: Any, code: str = "f4", bounds: bool = False, **more: Any) -> int:
        """Add a dense array with an accessor of its own; 3-byte and 6-byte rows are padded to 4 and 8."""
        rows = np.asarray(rows).astype("<" + code)
        rows = rows.reshape(len(rows), -1)
        width = rows.shape[1]
        padding = 0 if width == 1 else -rows.strides[0] % 4
        data = b"".join(row.tobytes() + bytes(padding) for row in rows)
        stride = {"byteStride": len(data) // len(rows)} if padding else {}
        plain = more.pop("plain", False)
        target = {} if plain else {"target": 34963 if width == 1 else 34962}
        view = self.view(data, **stride, **target)
        if bounds:
            start = self.tree["bufferViews"][view]["byteOffset"]
            step = len(data) // len(rows)
            self.positions += [
                (start + i * step, start + i * step + rows[0].nbytes) for i in range(len(rows))
            ]
        return self.accessor(view, rows, code, bounds, **more)

    def accessor(
        self, view: int | None, rows: Any, code: str = "f4", bounds: bool = False, **more: Any
    ) -> int:
        where = {} if view is None else {"bufferView": view}
        limits = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()} if bounds else {}
        kind = _KINDS[rows.shape[1]]
        return self.put(
            "accessors", **where, componentType=_CODES[code], count=len(rows), type=kind, **limits, **more
        )

    def mesh(self, position: int, indices: int | None = None, **more: Any) -> int:
        attributes = {"POSITION": position, **more.pop("attributes", {})}
        pointer = {} if indices is None else {"indices": indices}
        return self.put("meshes", primitives=[{"attributes": attributes, **pointer, **more}])

    def node(self, root: bool = True, **item: Any) -> int:
        number = self.put("nodes", **item)
        if root:
            self.tree.setdefault("scenes", [{"nodes": []}])[0]["nodes"].append(number)
            self.tree["scene"] = 0
        return number

    def json(self, indent: int | None = 2, **buffer: Any) -> bytes:
        """Return the JSON text; numbers are spelled oddly in places, as other programs do."""
        tree = {
            "asset": {"version": "2.0", "generator": "tests \\u00e9 / \\"},
            "buffers": [{"byteLength": len(self.blob), **buffer}],
            **self.tree,
            "extras": {"ratio": "@1.50", "big": "@1E3", "bufferViews": [{"min": [1.0]}], "min": "@-0.0"},
        }
        text = json.dumps(tree, indent=indent)
        for odd in ("1.50", "1E3", "-0.0"):
            text = text.replace(f'"@{odd}"', odd)
        return text.encode()

    def glb(self, extra_chunk: bool = True, indent: int | None = 2) -> bytes:
        text = self.json(indent)
        text += b" " * (-len(text) % 4)
        data = bytes(self.blob) + b"\0" * (-len(self.blob) % 4)
        chunks = (
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
        )
        if extra_chunk:
            chunks += struct.pack("<I4s", 8, b"xTRA") + b"unknown!"
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def embedded(self) -> bytes:
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        return self.json(uri=uri)

    def external(self, folder: Path, name: str = "model.gltf") -> bytes:
        """Write the buffer beside and return the JSON text."""
        (folder / "old buffer.bin").write_bytes(self.blob)
        return self.json(uri="old%20buffer.bin")

    def position_mask(self) -> np.ndarray:
        mask = np.zeros(len(self.blob), bool)
        for start, end in self.positions:
            mask[start:end] = True
        return mask


def cube(scale: float = 1.0) -> Sample:
    """One cube, one node, nothing else."""
    sample = Sample()
    mesh = sample.mesh(sample.array(CUBE * scale, bounds=True), sample.array(CUBE_FACES.ravel(), "u2"))
    sample.node(mesh=mesh)
    return sample


def shared_positions() -> Sample:
    """Three primitives (8, 16 and 32 bit indices) over one POSITION accessor."""
    sample = cube()
    parts = [sample.array(CUBE_FACES[i::3].ravel(), code) for i, code in enumerate(("u1", "u2", "u4"))]
    sample.tree["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": i} for i in parts]}]
    return sample


def instances() -> Sample:
    """A cube shown three times by nested nodes, with a mirror, a matrix, and one flattened showing."""
    sample = cube()
    deep = sample.node(root=False, mesh=0, scale=[1, -2, 0.5], translation=[0.25, 5, 1e-3])
    flat = sample.node(root=False, mesh=0, scale=[1, 0, 1])
    sample.node(rotation=[0.5, 0.5, -0.5, 0.5], translation=[3, 0, 0], children=[deep, flat], name="parent")
    sample.node(mesh=0, matrix=[2, 0.5, 0, 0, 0, 2, 0, 0, 0, 0.25, 2, 0, 10, 20, 30, 1])
    return sample


def interleaved() -> Sample:
    """Positions, normals and texture coordinates in one bufferView with a stride."""
    sample = Sample()
    rows = np.hstack([CUBE, UNIT, CUBE[:, :2]]).astype("<f4")
    view = sample.view(rows.tobytes(), byteStride=32, target=34962)
    sample.positions = [(32 * i, 32 * i + 12) for i in range(8)]
    position = sample.accessor(view, rows[:, :3], bounds=True)
    normal = sample.accessor(view, rows[:, 3:6], byteOffset=12)
    texcoord = sample.accessor(view, rows[:, 6:], byteOffset=24)
    indices = sample.array(CUBE_FACES.ravel(), "u2")
    sample.node(mesh=sample.mesh(position, indices, attributes={"NORMAL": normal, "TEXCOORD_0": texcoord}))
    return sample


def sparse() -> Sample:
    """Rows 2 and 5 replaced by sparse values over a base accessor."""
    sample = cube()
    values = CUBE[[2, 5]].astype("<f4") + np.float32(0.3)
    record = sample.tree["accessors"][0]
    where = {"bufferView": sample.view(np.array([2, 5], "<u2").tobytes()), "componentType": 5123}
    view = sample.view(values.tobytes())
    start = sample.tree["bufferViews"][view]["byteOffset"]
    record["sparse"] = {"count": 2, "indices": where, "values": {"bufferView": view}}
    full = CUBE.copy()
    full[[2, 5]] = values
    record |= {"min": full.min(axis=0).astype("f4").tolist(), "max": full.max(axis=0).astype("f4").tolist()}
    sample.positions += [(start, start + 24)]
    return sample


def quantised() -> Sample:
    """Positions as normalised 16-bit, plain unsigned 16-bit, and normalised 8-bit integers."""
    sample = Sample()
    sample.tree |= {key: ["KHR_mesh_quantization"] for key in ("extensionsUsed", "extensionsRequired")}
    steps = np.rint(CUBE / 2.3 * 30000)
    indices = sample.array(CUBE_FACES.ravel(), "u2")
    for code, rows, scaled in (("i2", steps, True), ("u2", steps, False), ("i1", np.rint(steps / 300), True)):
        extra = {"normalized": True} if scaled else {}
        mesh = sample.mesh(sample.array(rows, code, bounds=True, **extra), indices)
        sample.node(mesh=mesh, scale=[1, 1, 1] if scaled else [1e-4, 1e-4, 1e-4], translation=[mesh, 0, 0])
    return sample


def modes() -> Sample:
    """A strip, a fan, triangles without indices, and points that are no part of the surface."""
    sample = Sample()
    sample.node(
        mesh=sample.mesh(sample.array(CUBE, bounds=True), sample.array([0, 1, 2, 3, 6], "u1"), mode=5)
    )
    sample.node(mesh=sample.mesh(sample.array(CUBE[:5], bounds=True), mode=6))
    sample.node(mesh=sample.mesh(sample.array(CUBE[CUBE_FACES.ravel()], bounds=True)))
    kept = list(sample.positions)
    sample.node(mesh=sample.mesh(sample.array(CUBE, bounds=True), mode=0))
    sample.positions = kept
    return sample


def rich() -> Sample:
    """Everything at once: materials, image, skin, animation, morph targets, camera, extensions, orphans."""
    sample = instances()
    sample.tree["extensionsUsed"] = ["VENDOR_unknown", "KHR_materials_unlit"]
    png = base64.b64decode(
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
    )
    image = sample.put("images", bufferView=sample.view(png), mimeType="image/png")
    texture = sample.put("textures", source=image, sampler=sample.put("samplers", magFilter=9729))
    material = sample.put(
        "materials",
        pbrMetallicRoughness={"baseColorTexture": {"index": texture}},
        extensions={"KHR_materials_unlit": {}},
    )
    sample.put("cameras", type="perspective", perspective={"yfov": 0.8, "znear": 0.1})
    extra = {
        "NORMAL": sample.array(UNIT),
        "TANGENT": sample.array(np.tile([1.0, 0, 0, 1], (8, 1))),
        "TEXCOORD_0": sample.array(CUBE[:, :2] / 3),
        "COLOR_0": sample.array(np.tile([255, 128, 0, 255], (8, 1)), "u1", normalized=True),
        "JOINTS_0": sample.array(np.tile([0, 1, 0, 0], (8, 1)), "u1"),
        "WEIGHTS_0": sample.array(np.tile([0.75, 0.25, 0, 0], (8, 1))),
    }
    offsets = (CUBE * 0.1).astype("f4")
    target = sample.array(offsets)
    record = sample.tree["accessors"][target]
    record |= {"min": offsets.min(axis=0).tolist(), "max": offsets.max(axis=0).tolist()}
    skinned = sample.mesh(
        sample.array(CUBE * 2, bounds=True),
        sample.array(CUBE_FACES.ravel(), "u1"),
        attributes=extra,
        material=material,
        targets=[{"POSITION": target}],
        extras={"part": 7},
    )
    joints = [sample.node(root=False, name="tip"), 0]
    joints[1] = sample.node(root=True, children=[joints[0]], translation=[0, 1, 0], name="bone")
    inverse = sample.array(np.tile(np.eye(4).ravel(), (2, 1)), plain=True)
    skin = sample.put("skins", joints=joints[::-1], inverseBindMatrices=inverse)
    sample.node(mesh=skinned, skin=skin, camera=0, extensions={"VENDOR_unknown": {"deep": [1, {"max": [9]}]}})
    times = sample.array([0.0, 1.0], plain=True)
    sample.tree["accessors"][times] |= {"min": [0.0], "max": [1.0]}
    sampler = {"input": times, "output": sample.array(np.ones((2, 3)), plain=True), "interpolation": "LINEAR"}
    channel = {"sampler": 0, "target": {"node": joints[0], "path": "translation"}}
    sample.put("animations", samplers=[sampler], channels=[channel])
    kept = list(sample.positions)
    sample.mesh(sample.array(CUBE * 3, bounds=True))
    sample.positions = kept
    return sample


SAMPLES = {
    item.__name__: item
    for item in (cube, shared_positions, instances, interleaved, sparse, quantised, modes, rich)
}

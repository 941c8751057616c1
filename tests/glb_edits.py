"""Changes of what a GLB shows that leave its positions as they are; tests apply them to marked files."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PIL import Image

from meshmark.mesh import FloatArray, IntArray

_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_CODES = {"u1": 5121, "u2": 5123, "u4": 5125, "f4": 5126}


@dataclass
class Glb:
    """A GLB taken apart, to be changed in place."""

    tree: dict[str, Any]
    blob: bytearray = field(default_factory=bytearray)

    @classmethod
    def read(cls, data: bytes) -> Glb:
        size = struct.unpack_from("<I", data, 12)[0]
        tree = json.loads(data[20 : 20 + size])
        return cls(tree, bytearray(data[28 + size :][: tree["buffers"][0]["byteLength"]]))

    def bytes(self) -> bytes:
        self.blob += bytes(-len(self.blob) % 4)
        self.tree["buffers"] = [{"byteLength": len(self.blob)}]
        text = json.dumps(self.tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.blob), b"BIN\0") + bytes(self.blob)
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def put(self, key: str, **item: Any) -> int:
        self.tree.setdefault(key, []).append(item)
        return len(self.tree[key]) - 1

    def view(self, data: bytes) -> int:
        self.blob += bytes(-len(self.blob) % 4)
        view = self.put("bufferViews", buffer=0, byteOffset=len(self.blob), byteLength=len(data))
        self.blob += data
        return view

    def array(self, rows: Any, code: str = "f4") -> int:
        rows = np.asarray(rows).astype("<" + code)
        rows = rows.reshape(len(rows), -1)
        limits = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        kind = _KINDS[rows.shape[1]]
        view = self.view(rows.tobytes())
        return self.put(
            "accessors", bufferView=view, componentType=_CODES[code], count=len(rows), type=kind, **limits
        )

    @property
    def primitive(self) -> dict[str, Any]:
        return self.tree["meshes"][0]["primitives"][0]

    @property
    def node(self) -> dict[str, Any]:
        return next(node for node in self.tree["nodes"] if "mesh" in node)

    @property
    def count(self) -> int:
        return self.tree["accessors"][self.primitive["attributes"]["POSITION"]]["count"]

    def paint(self, **material: Any) -> None:
        self.primitive["material"] = self.put("materials", **material)

    def extend(self, holder: dict[str, Any], name: str, **value: Any) -> None:
        holder.setdefault("extensions", {})[name] = value
        self.tree.setdefault("extensionsUsed", []).append(name)


def plain_glb(points: FloatArray, faces: IntArray) -> bytes:
    """Return one mesh in one node of one scene."""
    made = Glb({"asset": {"version": "2.0"}})
    position, indices = made.array(points), made.array(faces.ravel(), "u4")
    made.put("meshes", primitives=[{"attributes": {"POSITION": position}, "indices": indices}])
    made.put("nodes", mesh=0)
    made.tree |= {"scenes": [{"nodes": [0]}], "scene": 0}
    return made.bytes()


def _bulge(glb: Glb, weight: float) -> None:
    shift = np.zeros((glb.count, 3))
    shift[::2, 1] = 1.0
    glb.primitive["targets"] = [{"POSITION": glb.array(shift)}]
    glb.tree["meshes"][0]["weights"] = [weight]


def morph_weights(glb: Glb) -> None:
    _bulge(glb, 1.0)


def weights_of_the_node(glb: Glb) -> None:
    _bulge(glb, 0.0)
    glb.node["weights"] = [0.7]


def _skin(glb: Glb, shift: float) -> None:
    joints = np.zeros((glb.count, 4))
    joints[: glb.count // 2, 0] = 1
    weights = np.tile([1.0, 0.0, 0.0, 0.0], (glb.count, 1))
    glb.primitive["attributes"] |= {"JOINTS_0": glb.array(joints, "u1"), "WEIGHTS_0": glb.array(weights)}
    one = glb.put("nodes", name="hip")
    two = glb.put("nodes", name="neck", translation=[0.0, shift, 0.0])
    binds = np.tile(np.eye(4).ravel(), (2, 1))
    glb.node["skin"] = glb.put("skins", joints=[one, two], inverseBindMatrices=glb.array(binds))
    glb.tree["scenes"][0]["nodes"] += [one, two]


def skin_at_rest(glb: Glb) -> None:
    _skin(glb, 0.0)


def posed_skin(glb: Glb) -> None:
    _skin(glb, 0.5)


def weights_that_shrink(glb: Glb) -> None:
    _skin(glb, 0.0)
    weights = np.tile([0.5, 0.0, 0.0, 0.0], (glb.count, 1))
    glb.primitive["attributes"]["WEIGHTS_0"] = glb.array(weights)


def empty_default_scene(glb: Glb) -> None:
    glb.tree["scene"] = glb.put("scenes", nodes=[])


def no_scene(glb: Glb) -> None:
    del glb.tree["scene"], glb.tree["scenes"]


def instanced(glb: Glb) -> None:
    places = glb.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    glb.extend(glb.node, "EXT_mesh_gpu_instancing", attributes={"TRANSLATION": places})


def added_lines(glb: Glb) -> None:
    ends = glb.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    glb.tree["meshes"][0]["primitives"].append({"attributes": {"POSITION": ends}, "mode": 1})


def added_points(glb: Glb) -> None:
    cloud = glb.array(np.random.default_rng(1).normal(size=(500, 3)))
    glb.tree["scenes"][0]["nodes"].append(
        glb.put("nodes", mesh=glb.put("meshes", primitives=[{"attributes": {"POSITION": cloud}, "mode": 0}]))
    )


def transparent(glb: Glb) -> None:
    glb.paint(alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0]})


def cut_out(glb: Glb) -> None:
    glb.paint(alphaMode="MASK", alphaCutoff=0.9, pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.8]})


def clear_texture(glb: Glb) -> None:
    packed = io.BytesIO()
    Image.new("RGBA", (4, 4), (255, 255, 255, 0)).save(packed, "PNG")
    image = glb.put("images", bufferView=glb.view(packed.getvalue()), mimeType="image/png")
    glb.primitive["attributes"]["TEXCOORD_0"] = glb.array(np.full((glb.count, 2), 0.3))
    texture = {"index": glb.put("textures", source=image)}
    glb.paint(alphaMode="MASK", pbrMetallicRoughness={"baseColorTexture": texture})


def clear_colours(glb: Glb) -> None:
    colours = np.tile([1.0, 1.0, 1.0, 0.0], (glb.count, 1))
    glb.primitive["attributes"]["COLOR_0"] = glb.array(colours)
    glb.paint(alphaMode="BLEND")


def glass(glb: Glb) -> None:
    glb.paint()
    glb.extend(glb.tree["materials"][-1], "KHR_materials_transmission", transmissionFactor=1.0)


def invisible_node(glb: Glb) -> None:
    glb.extend(glb.node, "KHR_node_visibility", visible=False)


def level_of_detail(glb: Glb) -> None:
    other = glb.put("nodes", mesh=glb.put("meshes", primitives=[{"attributes": {}, "mode": 0}]))
    glb.extend(glb.node, "MSFT_lod", ids=[other])


def _animate(glb: Glb, path: str, values: Any, **target: Any) -> None:
    sampler = {"input": glb.array([0.0, 1.0]), "output": glb.array(values)}
    glb.put("animations", samplers=[sampler], channels=[{"sampler": 0, "target": {"path": path, **target}}])


def animated_morph(glb: Glb) -> None:
    _bulge(glb, 0.0)
    _animate(glb, "weights", [0.0, 1.0], node=glb.tree["nodes"].index(glb.node))


def animated_skin(glb: Glb) -> None:
    skin_at_rest(glb)
    _animate(glb, "translation", np.zeros((2, 3)), node=glb.tree["skins"][0]["joints"][1])


def animated_node(glb: Glb) -> None:
    _animate(glb, "translation", np.zeros((2, 3)), node=glb.tree["nodes"].index(glb.node))


def animated_property(glb: Glb) -> None:
    _animate(
        glb, "pointer", [0.0, 1.0], extensions={"KHR_animation_pointer": {"pointer": "/nodes/0/extensions"}}
    )


CHANGES: dict[Callable[[Glb], None], str] = {
    morph_weights: "morph_weights",
    weights_of_the_node: "morph_weights",
    posed_skin: "skin",
    weights_that_shrink: "skin",
    empty_default_scene: "scene",
    no_scene: "scene",
    instanced: "instancing",
    added_lines: "lines",
    added_points: "points",
    transparent: "hidden_material",
    cut_out: "hidden_material",
    clear_texture: "hidden_material",
    clear_colours: "hidden_material",
    glass: "hidden_material",
    invisible_node: "hidden_node",
    level_of_detail: "levels_of_detail",
    animated_morph: "morph_animation",
    animated_skin: "skeletal_animation",
    animated_node: "node_animation",
    animated_property: "pointer_animation",
}
"""Each change that shows something else, and the kind of deviation that it is."""


def named_node(glb: Glb) -> None:
    glb.node["name"] = "other"


def turned_node(glb: Glb) -> None:
    glb.node.update(rotation=[0.0, 0.6, 0.0, 0.8], scale=[3.0, 3.0, 3.0], translation=[5.0, 1.0, 2.0])


def red(glb: Glb) -> None:
    glb.paint(name="red", pbrMetallicRoughness={"baseColorFactor": [0.8, 0.1, 0.1, 1.0]})


def blended(glb: Glb) -> None:
    glb.paint(alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [0.8, 0.1, 0.1, 0.6]})


def idle_targets(glb: Glb) -> None:
    _bulge(glb, 0.0)


def unused_scene(glb: Glb) -> None:
    glb.put("scenes", nodes=[glb.put("nodes", name="empty")])


def camera(glb: Glb) -> None:
    eye = glb.put("cameras", type="perspective", perspective={"yfov": 0.7, "znear": 0.01})
    glb.tree["scenes"][0]["nodes"].append(glb.put("nodes", camera=eye))


HARMLESS: tuple[Callable[[Glb], None], ...] = (
    named_node,
    turned_node,
    red,
    blended,
    skin_at_rest,
    idle_targets,
    unused_scene,
    camera,
)
"""Changes after which a viewer still shows the surface as it was signed off."""


def changed(data: bytes, change: Callable[[Glb], None]) -> bytes:
    """Return the GLB after a change."""
    glb = Glb.read(data)
    change(glb)
    return glb.bytes()

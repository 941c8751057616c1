"""What a glTF paints its surface with, in canonical words, equal for files that look alike.

Where a material breaks the format, so that viewers answer in different ways, the one word says so.
"""

from __future__ import annotations

import json
from hashlib import blake2b
from typing import Any

from meshmark.errors import FormatError
from meshmark.io.gltf.base_colour import material_of
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.images import image_bytes, image_of_texture
from meshmark.io.gltf.scene import Scene
from meshmark.io.gltf.schema import Json

__all__ = ["gltf_looks"]

# What a material is where it does not say (glTF 2.0, section 5.19).
_DEFAULTS: Json = {
    "alphaMode": "OPAQUE",
    "doubleSided": False,
    "emissiveFactor": [0.0, 0.0, 0.0],
    "pbrMetallicRoughness": {
        "baseColorFactor": [1.0, 1.0, 1.0, 1.0],
        "metallicFactor": 1.0,
        "roughnessFactor": 1.0,
    },
}
# Names, notes, and where on a texture a point lies, which exports lawfully choose anew.
_IGNORED = ("name", "extras", "texCoord", "KHR_texture_transform", "alphaCutoff", "sampler", "variants")
# Numbers are told apart to this many steps in one.
_STEPS = 128
_BYTES = 12


def gltf_looks(container: Container, scene: Scene) -> tuple[str, ...]:
    """Return one word for each kind of material on the surface, sorted; none for the default material.

    A word is a digest of the material's numbers, rounded, and of the bytes of its images.
    """
    try:
        return _looks(container, scene)
    except FormatError:
        return ("broken",)


def _looks(container: Container, scene: Scene) -> tuple[str, ...]:
    found = set()
    digests: dict[int, str] = {}
    default = _canonical(container, dict(_DEFAULTS), digests)
    for primitives in scene.primitives.values():
        for primitive in primitives:
            material = {**_DEFAULTS, **material_of(container, primitive)}
            plain = material.get("pbrMetallicRoughness")
            if isinstance(plain, dict):
                material["pbrMetallicRoughness"] = {**_DEFAULTS["pbrMetallicRoughness"], **plain}
            text = _canonical(container, material, digests)
            if text != default:
                found.add(blake2b(text.encode(), digest_size=_BYTES).hexdigest())
    return tuple(sorted(found))


def _canonical(container: Container, material: Json, digests: dict[int, str]) -> str:
    return json.dumps(_plain(container, material, digests), sort_keys=True, separators=(",", ":"))


def _plain(container: Container, value: Any, digests: dict[int, str]) -> Any:
    if isinstance(value, dict):
        inner = {
            name: _plain(container, item, digests)
            for name, item in value.items()
            if name not in _IGNORED and not (name == "extensions" and not item)
        }
        if "index" in value:  # a texture info object
            inner["index"] = _image(container, value, digests)
        return {name: item for name, item in inner.items() if item != {}}
    if isinstance(value, list):
        return [_plain(container, item, digests) for item in value]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return round(min(max(float(value), -1e6), 1e6) * _STEPS)
    return value


def _image(container: Container, info: Json, digests: dict[int, str]) -> str:
    image = image_of_texture(container, info)
    if image is None:
        return ""
    if image not in digests:
        digests[image] = blake2b(image_bytes(container, image), digest_size=_BYTES).hexdigest()
    return digests[image]

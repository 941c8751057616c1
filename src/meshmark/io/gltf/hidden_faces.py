"""Which faces of a glTF primitive nobody sees, because their material lets all light through.

glTF 2.0, section 3.9.4 (alpha coverage), KHR_materials_transmission, KHR_texture_transform.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.images import alpha_of, image_bytes, image_of_texture
from meshmark.io.gltf.scene import Primitive
from meshmark.io.gltf.schema import Json, numbers, reference
from meshmark.io.gltf.views import extension
from meshmark.mesh import FloatArray

__all__ = ["hidden_faces", "material_of"]

# What is blended with less than this is not seen; nor is what lets through more than this share of the light.
_FAINT, _CLEAR = 0.05, 0.9
_CUTOFF = 0.5


def material_of(container: Container, primitive: Primitive) -> Json:
    """Return the material of a primitive, empty for the default one."""
    materials = container.tables["materials"]
    index = reference(primitive.item, "material", "primitive", materials)
    return {} if index is None else materials[index]


def hidden_faces(container: Container, primitive: Primitive, rows: int) -> NDArray[np.bool_]:
    """Return (m,): the faces that are not seen; rows: of the primitive's position accessor."""
    material = material_of(container, primitive)
    hidden = np.zeros(len(primitive.faces), bool)
    if _number(extension(material, "KHR_materials_transmission") or {}, "transmissionFactor", 0.0) > _CLEAR:
        return ~hidden
    mode = material.get("alphaMode", "OPAQUE")
    if mode not in ("MASK", "BLEND"):
        return hidden
    least = _number(material, "alphaCutoff", _CUTOFF) if mode == "MASK" else _FAINT
    factor, texture = _base(material)
    alpha = np.full(rows, factor)
    if "COLOR_0" in primitive.attributes:
        colours = open_accessor(container, primitive.attributes["COLOR_0"]).values(container.blob)
        if colours.shape == (rows, 4):
            alpha = alpha * colours[:, 3]
    corners = alpha[primitive.faces]
    seen = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
    sampled = _sampled(container, primitive, texture, rows)
    if sampled is not None:
        seen = seen * sampled
    return np.asarray((seen < least).all(axis=1))


def _base(material: Json) -> tuple[float, object]:
    """Return the alpha factor of a material, and the texture info object of its alpha or None."""
    glossy = extension(material, "KHR_materials_pbrSpecularGlossiness") or {}
    if glossy:
        return numbers(glossy, "diffuseFactor", "material", [1.0] * 4)[3], glossy.get("diffuseTexture")
    plain = material.get("pbrMetallicRoughness")
    plain = plain if isinstance(plain, dict) else {}
    return numbers(plain, "baseColorFactor", "material", [1.0] * 4)[3], plain.get("baseColorTexture")


def _sampled(container: Container, primitive: Primitive, texture: object, rows: int) -> FloatArray | None:
    """Return (m, 4): the texture's alpha at the corners and the middle of each face; None where it is 1."""
    image = image_of_texture(container, texture)
    if image is None or not isinstance(texture, dict):
        return None
    alpha = _alpha(image_bytes(container, image))
    transform = extension(texture, "KHR_texture_transform") or {}
    channel = transform.get("texCoord", texture.get("texCoord", 0))
    name = f"TEXCOORD_{channel}"
    if alpha is None or name not in primitive.attributes:
        return None
    places = open_accessor(container, primitive.attributes[name]).values(container.blob)
    if places.shape != (rows, 2):
        raise FormatError(f"{name} has another number of rows than the positions it belongs to")
    offset = numbers(transform, "offset", "texture transform", [0.0, 0.0])
    scale = numbers(transform, "scale", "texture transform", [1.0, 1.0])
    turn = _number(transform, "rotation", 0.0)
    c, s = math.cos(turn), math.sin(turn)
    places = (places * scale) @ np.array([[c, -s], [s, c]]) + offset
    corners = places[primitive.faces]
    corners = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
    size = np.array(alpha.shape[::-1])
    pixel = np.floor(np.nan_to_num(corners - np.floor(corners)) * size).astype(np.int64).clip(0, size - 1)
    return np.asarray(alpha[pixel[..., 1], pixel[..., 0]])


@lru_cache(maxsize=4)
def _alpha(encoded: bytes) -> FloatArray | None:
    return alpha_of(encoded)


def _number(item: Json, name: str, default: float) -> float:
    found: Any = item.get(name, default)
    return float(found) if isinstance(found, (int, float)) and math.isfinite(found) else default

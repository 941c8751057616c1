"""The base colour of a glTF material, and where the corners of triangles lie on its texture.

glTF 2.0, section 3.9.2, KHR_materials_pbrSpecularGlossiness, KHR_texture_transform.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.scene import Primitive
from meshmark.io.gltf.schema import Json, numbers, reference
from meshmark.io.gltf.views import extension
from meshmark.mesh import FloatArray

__all__ = ["base_colour", "material_of", "number", "texture_places"]


def material_of(container: Container, primitive: Primitive) -> Json:
    """Return the material of a primitive, empty for the default one."""
    materials = container.tables["materials"]
    index = reference(primitive.item, "material", "primitive", materials)
    return {} if index is None else materials[index]


def base_colour(material: Json) -> tuple[list[float], object]:
    """Return the RGBA factor of a material, linear, and the texture info object of its colour or None."""
    glossy = extension(material, "KHR_materials_pbrSpecularGlossiness") or {}
    if glossy:
        return numbers(glossy, "diffuseFactor", "material", [1.0] * 4), glossy.get("diffuseTexture")
    plain = material.get("pbrMetallicRoughness")
    plain = plain if isinstance(plain, dict) else {}
    return numbers(plain, "baseColorFactor", "material", [1.0] * 4), plain.get("baseColorTexture")


def texture_places(container: Container, primitive: Primitive, texture: Json, rows: int) -> FloatArray | None:
    """Return (m, 3, 2): where the corners lie on a texture, from its upper left corner; None where nothing says it.

    texture: a texture info object. rows: of the primitive's position accessor. Raises `FormatError` where there are
    more or fewer texture coordinates than positions.
    """
    transform = extension(texture, "KHR_texture_transform") or {}
    name = f"TEXCOORD_{transform.get('texCoord', texture.get('texCoord', 0))}"
    if name not in primitive.attributes:
        return None
    places = open_accessor(container, primitive.attributes[name]).values(container.blob)
    if places.shape != (rows, 2):
        raise FormatError(f"{name} has another number of rows than the positions it belongs to")
    offset = numbers(transform, "offset", "texture transform", [0.0, 0.0])
    scale = numbers(transform, "scale", "texture transform", [1.0, 1.0])
    turn = number(transform, "rotation", 0.0)
    c, s = math.cos(turn), math.sin(turn)
    placed = (places * scale) @ np.array([[c, -s], [s, c]]) + offset
    return np.asarray(placed[primitive.faces])


def number(item: Json, name: str, default: float) -> float:
    """Return a number of an object, the default where it has none or one that is not finite."""
    found: Any = item.get(name, default)
    return float(found) if isinstance(found, (int, float)) and math.isfinite(found) else default

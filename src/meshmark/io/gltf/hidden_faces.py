"""Which faces of a glTF primitive nobody sees, because their material lets all light through.

glTF 2.0, section 3.9.4 (alpha coverage), KHR_materials_transmission.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.base_colour import base_colour, material_of, number, texture_places
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.images import alpha_of, image_bytes, image_of_texture
from meshmark.io.gltf.scene import Primitive
from meshmark.io.gltf.views import extension
from meshmark.mesh import FloatArray

__all__ = ["hidden_faces"]

# What is blended with less than this is not seen; nor is what lets through more than this share of the light.
_FAINT, _CLEAR = 0.05, 0.9
_CUTOFF = 0.5


def hidden_faces(container: Container, primitive: Primitive, rows: int) -> NDArray[np.bool_]:
    """Return (m,): the faces that are not seen; rows: of the primitive's position accessor."""
    material = material_of(container, primitive)
    hidden = np.zeros(len(primitive.faces), bool)
    if number(extension(material, "KHR_materials_transmission") or {}, "transmissionFactor", 0.0) > _CLEAR:
        return ~hidden
    mode = material.get("alphaMode", "OPAQUE")
    if mode not in ("MASK", "BLEND"):
        return hidden
    least = number(material, "alphaCutoff", _CUTOFF) if mode == "MASK" else _FAINT
    factor, texture = base_colour(material)
    alpha = np.full(rows, factor[3])
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


def _sampled(container: Container, primitive: Primitive, texture: object, rows: int) -> FloatArray | None:
    """Return (m, 4): the texture's alpha at the corners and the middle of each face; None where it is 1."""
    image = image_of_texture(container, texture)
    if image is None or not isinstance(texture, dict):
        return None
    alpha = _alpha(image_bytes(container, image))
    corners = None if alpha is None else texture_places(container, primitive, texture, rows)
    if alpha is None or corners is None:
        return None
    corners = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
    size = np.array(alpha.shape[::-1])
    pixel = np.floor(np.nan_to_num(corners - np.floor(corners)) * size).astype(np.int64).clip(0, size - 1)
    return np.asarray(alpha[pixel[..., 1], pixel[..., 0]])


@lru_cache(maxsize=4)
def _alpha(encoded: bytes) -> FloatArray | None:
    return alpha_of(encoded)

"""The images of a glTF: their bytes, and the alpha of those that Pillow can read."""

from __future__ import annotations

import base64
import binascii
import io
import warnings

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.container import Container, local_name
from meshmark.io.gltf.schema import Json, reference
from meshmark.io.gltf.views import extension
from meshmark.io.inside import read_inside

__all__ = ["alpha_of", "image_bytes", "image_of_texture"]

# Extensions of a texture that name another image; a viewer that knows one shows that.
_OTHERS = ("KHR_texture_basisu", "EXT_texture_avif", "EXT_texture_webp", "MSFT_texture_dds")
_MOST_PIXELS = 1 << 26
_LONGEST = 1 << 28


def image_of_texture(container: Container, info: object) -> int | None:
    """Return the image that a texture info object names, None where it names none."""
    if not isinstance(info, dict):
        return None
    tables = container.tables
    index = reference(info, "index", "texture info", tables["textures"])
    if index is None:
        return None
    texture = tables["textures"][index]
    for holder in [*filter(None, (extension(texture, name) for name in _OTHERS)), texture]:
        image = reference(holder, "source", f"texture {index}", tables["images"])
        if image is not None:
            return image
    return None


def image_bytes(container: Container, image: int) -> bytes:
    """Return the encoded bytes of an image, empty where they are not at hand."""
    item = container.tables["images"][image]
    try:
        return _bytes(container, item, image)
    except (FormatError, OSError, binascii.Error, ValueError):
        return b""


def _bytes(container: Container, item: Json, image: int) -> bytes:
    view = reference(item, "bufferView", f"image {image}", container.tables["bufferViews"])
    if view is not None:
        start, size = container.view_span(view)
        return container.blob[start : start + size].tobytes()
    uri = item.get("uri")
    if not isinstance(uri, str):
        return b""
    if uri.startswith("data:"):
        return base64.b64decode(uri[uri.index(",") + 1 :], validate=True)
    return read_inside(container.path.parent, local_name(uri, f"image {image}"), _LONGEST)


def alpha_of(encoded: bytes) -> NDArray[np.float64] | None:
    """Return the alpha (h, w) of an encoded image, 0 to 1; None where it has none, or cannot be read."""
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            opened = Image.open(io.BytesIO(encoded))
            if opened.width * opened.height > _MOST_PIXELS or not (
                "A" in opened.getbands() or "transparency" in opened.info
            ):
                return None
            return np.asarray(opened.convert("RGBA").getchannel("A"), np.float64) / 255.0
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError):
        return None

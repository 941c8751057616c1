"""The paint of a surface as an interactive view takes it: colours of corners, and images in the page."""

from __future__ import annotations

import base64
import io
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from meshmark.io.paint import Paint

__all__ = ["fits", "skin_of"]

_MOST_IMAGES: Final = 16
_SIDES: Final = (1024, 512, 256)
_MOST_BYTES: Final = 3 << 20
"""Of all images together."""
_QUALITY, _SMALL, _GRID = 85, 64, 65535


def fits(paint: Paint) -> bool:
    """Return whether a page can hold the images of a paint."""
    return len(paint.images) <= _MOST_IMAGES


def skin_of(paint: Paint) -> dict[str, Any]:
    """Return the images of m painted triangles as JSON, where arrays are still numpy's.

    images: addresses with the image in them. image: (m,) uint8, place in images plus 1, 0 for none. places:
    (m, 3, 2) uint16 on a grid from `low` to `high`, in widths and heights of the image, from its upper left
    corner. Whole
    numbers are taken from the places of a triangle, as images repeat themselves.
    """
    places = paint.places - np.floor(paint.places.min(axis=1, keepdims=True))
    places[paint.image < 0] = 0.0
    low, high = places.min(axis=(0, 1)), places.max(axis=(0, 1))
    grid = (places - low) / np.where(high > low, high - low, 1.0) * _GRID
    return {
        "images": _addresses(paint.images),
        "image": (paint.image + 1).astype(np.uint8),
        "places": np.round(grid).astype(np.uint16),
        "low": low.tolist(),
        "high": high.tolist(),
    }


def _addresses(images: tuple[NDArray[np.uint8], ...]) -> list[str]:
    """Return the images as addresses of data, smaller where they would be too large together."""
    packed: list[tuple[str, bytes]] = []
    for side in _SIDES:
        packed = [_packed(each, side) for each in images]
        if sum(len(data) for _, data in packed) <= _MOST_BYTES:
            break
    return [f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}" for kind, data in packed]


def _packed(pixels: NDArray[np.uint8], side: int) -> tuple[str, bytes]:
    from PIL import Image

    shown = Image.fromarray(pixels)
    shown.thumbnail((side, side))
    stream = io.BytesIO()
    if max(shown.size) <= _SMALL:  # a palette of few pixels, whose edges must stay sharp
        shown.save(stream, "PNG", optimize=True)
        return "png", stream.getvalue()
    shown.save(stream, "JPEG", quality=_QUALITY)
    return "jpeg", stream.getvalue()

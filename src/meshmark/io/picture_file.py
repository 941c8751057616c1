"""An image of a model as pixels, no larger than a picture of the model needs."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray

__all__ = ["pixels_of"]

_MOST_PIXELS = 1 << 26
_SIDE = 1024


def pixels_of(encoded: bytes) -> NDArray[np.uint8] | None:
    """Return (h, w, 3) sRGB bytes, at most 1,024 each way; None for what Pillow cannot read, or is very large."""
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            opened = Image.open(io.BytesIO(encoded))
            if opened.width * opened.height > _MOST_PIXELS:
                return None
            opened.draft("RGB", (_SIDE, _SIDE))
            shown = opened.convert("RGB")
            shown.thumbnail((_SIDE, _SIDE))
            return np.asarray(shown)
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError):
        return None

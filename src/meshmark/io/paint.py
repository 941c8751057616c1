"""What the triangles of a surface are painted with: colours and images, for pictures of a model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import IntArray

__all__ = ["Coat", "Paint", "painted_by"]

Thin = NDArray[np.float32]


@dataclass(frozen=True, eq=False, kw_only=True)
class Coat:
    """What k triangles that lie together in a file are painted with.

    count: k. factor: linear RGB. image: (h, w, 3) sRGB bytes, None for none. places: (k, 3, 2) of the corners on
    the image, from its upper left corner, in its width and height; None where there is no image.
    """

    count: int
    factor: tuple[float, float, float]
    image: NDArray[np.uint8] | None = None
    places: Thin | None = None

    @property
    def is_plain(self) -> bool:
        """Return whether nothing says what colour the triangles have."""
        return self.image is None and self.factor == (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Paint:
    """The paint of m triangles.

    factor: (m, 3) linear RGB, by which images and colours of vertices are multiplied. images: (h, w, 3) sRGB bytes
    each. image: (m,) place in images, -1 for none. places: (m, 3, 2) of the corners on it, as in `Coat`; an image
    repeats itself outside 0 to 1.
    """

    factor: Thin
    image: NDArray[np.int32]
    places: Thin
    images: tuple[NDArray[np.uint8], ...]

    def take(self, faces: IntArray) -> Paint:
        """Return the paint of some of the triangles."""
        return replace(self, factor=self.factor[faces], image=self.image[faces], places=self.places[faces])


def painted_by(coats: list[Coat]) -> Paint | None:
    """Return the paint of the triangles of all coats, in their order; None where all of them are plain."""
    if all(coat.is_plain for coat in coats):
        return None
    images = {id(coat.image): coat.image for coat in coats if coat.image is not None}
    number = {key: place for place, key in enumerate(images)}
    counts = [coat.count for coat in coats]
    return Paint(
        factor=np.repeat(np.array([coat.factor for coat in coats], np.float32), counts, axis=0),
        image=np.repeat(np.array([number.get(id(coat.image), -1) for coat in coats], np.int32), counts),
        places=np.concatenate(
            [
                np.zeros((coat.count, 3, 2), np.float32) if coat.places is None else coat.places
                for coat in coats
            ]
        ),
        images=tuple(images.values()),
    )

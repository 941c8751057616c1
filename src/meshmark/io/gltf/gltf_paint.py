"""What the triangles of a glTF are painted with: the base colours of its materials, and their images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.base_colour import base_colour, material_of, texture_places
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.images import image_bytes, image_of_texture
from meshmark.io.gltf.scene import Primitive, Scene
from meshmark.io.paint import Coat, Paint, painted_by
from meshmark.io.picture_file import pixels_of

__all__ = ["gltf_paint"]

Pictures = dict[int, NDArray[np.uint8] | None]


def gltf_paint(container: Container, scene: Scene) -> Paint | None:
    """Return the paint of the triangles of a scene in their order; None where all materials are the default one.

    A material that breaks the format counts as the default one.
    """
    pictures: Pictures = {}
    known: dict[int, list[Coat]] = {}
    coats: list[Coat] = []
    for showing in scene.nodes.showings:
        if not showing.affine.is_usable:
            continue
        mesh = showing.mesh
        if mesh not in known:
            known[mesh] = [_coat(container, scene, each, pictures) for each in scene.primitives[mesh]]
        coats += known[mesh]
    return painted_by(coats)


def _coat(container: Container, scene: Scene, primitive: Primitive, pictures: Pictures) -> Coat:
    count = len(primitive.faces)
    try:
        factor, texture = base_colour(material_of(container, primitive))
        red, green, blue = (min(max(value, 0.0), 1.0) for value in factor[:3])
        colour = (red, green, blue)
        image = image_of_texture(container, texture)
        if image is None or not isinstance(texture, dict):
            return Coat(count=count, factor=colour)
        rows = scene.accessors[primitive.position].count
        places = texture_places(container, primitive, texture, rows)
    except FormatError:
        return Coat(count=count, factor=(1.0, 1.0, 1.0))
    if image not in pictures:
        pictures[image] = pixels_of(image_bytes(container, image))
    pixels = pictures[image]
    if pixels is None or places is None:
        return Coat(count=count, factor=colour)
    return Coat(count=count, factor=colour, image=pixels, places=np.nan_to_num(places).astype(np.float32))

"""A square that wears an image of four colours, as GLB and as OBJ, made by hand."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.glb_edits import Glb, plain_glb

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
FOUR = np.array([[[230, 20, 20], [20, 200, 20]], [[20, 20, 230], [240, 240, 240]]], np.uint8)
"""sRGB: red and green above, blue and white below."""
PLACES = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
"""Of the corners on the image, from its upper left corner."""


def image(pixels: np.ndarray = FOUR, side: int = 64) -> bytes:
    """Return a PNG with the pixels drawn as squares."""
    packed = io.BytesIO()
    Image.fromarray(np.kron(pixels, np.ones((side, side, 1), np.uint8))).save(packed, "PNG")
    return packed.getvalue()


def textured_glb(path: Path, places: np.ndarray = PLACES, **texture: Any) -> Glb:
    """Write the square as a GLB and return it; texture: more of the texture info object."""
    made = Glb.read(plain_glb(CORNERS, FACES))
    made.put("images", bufferView=made.view(image()), mimeType="image/png")
    made.put("textures", source=0)
    made.paint(pbrMetallicRoughness={"baseColorTexture": {"index": 0, **texture}})
    made.primitive["attributes"]["TEXCOORD_0"] = made.array(places)
    path.write_bytes(made.bytes())
    return made


def textured_obj(path: Path, material: str = "map_Kd -s 1 1 1 skins/four.png") -> None:
    """Write the square as one polygon of an OBJ file, with its material library and image."""
    (path.parent / "skins").mkdir()
    (path.parent / "skins" / "four.png").write_bytes(image())
    (path.parent / "four.mtl").write_text(
        f"newmtl other\nKd 0 0 0\n\nnewmtl four\nKd 0.9 0.1 0.1\n{material}\n"
    )
    lines = ["mtllib four.mtl"]
    lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in CORNERS]
    lines += [f"vt {u:g} {1.0 - v:g}" for u, v in PLACES]
    path.write_text("\n".join([*lines, "usemtl four", "f 1/1 2/2 3/3 4/4", ""]))

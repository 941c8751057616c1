"""How the model of a file stands, where its format says which way is up."""

from __future__ import annotations

from typing import Final

from meshmark.geometry.view import Stance
from meshmark.mesh import Mesh

__all__ = ["STANCES", "stance_of"]

_Y_UP = Stance(up=(0.0, 1.0, 0.0), front=(0.0, 0.0, 1.0))
_Z_UP = Stance(up=(0.0, 0.0, 1.0), front=(0.0, -1.0, 0.0))
STANCES: Final = {"glb": _Y_UP, "gltf": _Y_UP, "3mf": _Z_UP, "stl": _Z_UP}
"""By format. glTF 2.0, section 3.4: y is up, the front faces +z. 3MF core specification, chapter 3: z is up; STL,
which machines read as they read 3MF, has its front where drawings do, towards -y."""


def stance_of(mesh: Mesh) -> Stance | None:
    """Return how the model of a file stands, None where its format does not say."""
    return None if mesh.document is None else STANCES.get(mesh.document.format)

"""A round trip through each file format, written as exporters write it.

Our own writers keep every digit where the format can. Most exporters do not, so the positions are first rounded to
what a typical one writes: six significant digits in OFF (libigl), six decimals in OBJ (Blender) and 3MF (lib3mf),
32-bit floats in PLY; STL and glTF hold 32-bit floats anyway. Only positions and faces make the trip.
A model that has no more digits than that comes back as it was (in STL with three vertices for each face).
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from meshmark.attacks.attack import Attacked, Function, Given
from meshmark.attacks.rounding import to_float32
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import FloatArray, Mesh

__all__ = ["WRITTEN_AS", "through_file"]

# What a number goes through before our writer gets it: a text format, or a type.
WRITTEN_AS = {"off": "%.6g", "obj": "%.6f", "3mf": "%.6f", "ply": "float32", "stl": "", "glb": "", "gltf": ""}


def through_file(format_name: str) -> Function:
    """Return the attack that writes a mesh to a file of a format and reads it back.

    Raises `InputError` where the format cannot hold the mesh.
    """

    def attack(mesh: Mesh, _strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
        rounded = Mesh(_as_written(mesh.vertices, WRITTEN_AS[format_name]), mesh.faces)
        with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
            path = Path(folder) / f"model.{format_name}"
            write_mesh(rounded, path)
            back = read_mesh(path)
        corners = mesh.faces.ravel() if format_name == "stl" else np.arange(len(mesh.vertices))
        return Attacked(mesh=Mesh(back.vertices, back.faces), origin=corners)

    attack.__doc__ = f"Write the mesh to a {format_name.upper()} file as exporters do, and read it back."
    return attack


def _as_written(vertices: FloatArray, how: str) -> FloatArray:
    if how.startswith("%"):
        return np.char.mod(how, vertices).astype(np.float64)
    return to_float32(vertices) if how == "float32" else vertices

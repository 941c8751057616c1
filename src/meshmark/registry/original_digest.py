"""What names an original: a digest of its geometry, the same for every file that holds the same positions."""

from __future__ import annotations

from hashlib import sha256

import numpy as np

from meshmark.mesh import Mesh

__all__ = ["digest_of_mesh"]


def digest_of_mesh(mesh: Mesh) -> str:
    """Return SHA-256 of positions (64-bit floats) and faces (64-bit integers) of a mesh, 64 hexadecimal digits."""
    found = sha256(f"meshmark original 1 {len(mesh.vertices)} {len(mesh.faces)}\n".encode())
    found.update(np.ascontiguousarray(mesh.vertices + 0.0, "<f8").tobytes())  # -0.0 is 0.0
    found.update(np.ascontiguousarray(mesh.faces, "<i8").tobytes())
    return found.hexdigest()

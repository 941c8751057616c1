"""The tamper map: a PLY of the suspect with its altered vertices in red and marked by a number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from meshmark.io.atomic_write import write_whole
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh

__all__ = ["ALTERED", "INTACT", "write_tamper_map"]

INTACT, ALTERED = (196, 194, 188), (208, 32, 32)
"""sRGB colours of vertices."""


def write_tamper_map(
    mesh: Mesh, altered: NDArray[np.bool_], path: Path | str, staging: Staging | None = None
) -> None:
    """Save the vertices (n, 3) in their order, the faces, colours, and `altered` (n,) as 0 or 1.

    Positions are in single precision where that holds them exactly. staging: takes the file, to move it into place
    together with others. Raises `OutputError` where the file cannot be written.
    """
    single = mesh.vertices.astype("<f4")
    real = "f4" if (single == mesh.vertices).all() else "f8"
    names = [(axis, f"<{real}") for axis in "xyz"] + [
        (name, "u1") for name in ("red", "green", "blue", "altered")
    ]
    rows = np.zeros(len(mesh.vertices), names)
    for axis, name in enumerate("xyz"):
        rows[name] = mesh.vertices[:, axis]
    colours = np.where(altered[:, None], ALTERED, INTACT)
    for channel, name in enumerate(("red", "green", "blue")):
        rows[name] = colours[:, channel]
    rows["altered"] = altered
    corners = np.zeros(len(mesh.faces), [("count", "u1"), ("at", "<i4", 3)])
    corners["count"] = 3
    corners["at"] = mesh.faces
    write_whole(path, _header(rows, len(corners)) + rows.tobytes() + corners.tobytes(), staging)


def _header(rows: NDArray[np.void], faces: int) -> bytes:
    kinds = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    lines = ["ply", "format binary_little_endian 1.0", "comment tamper map by meshmark: altered is 1, else 0"]
    lines.append(f"element vertex {len(rows)}")
    for name in rows.dtype.names or ():
        lines.append(f"property {kinds[rows.dtype[name].str]} {name}")
    lines += [f"element face {faces}", "property list uchar int vertex_indices", "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")

"""Make the model that `meshmark demo` marks: src/meshmark/data/hare.xz. The same bytes on every run.

.venv/bin/python tools/make_demo_model.py [OUT.xz]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from demo_model import hare
from demo_model.solids import Array
from demo_model.surface import Faces, extract, gradient, settle

from meshmark.data.packing import packed

CELL = 0.034
ROUNDS = 15
MILLIMETRES = 30.0
# Positions on a fine grid of millimetres, and triangles in order, pack better.
GRID = 2.0**-12
HOME = Path(__file__).resolve().parents[1] / "src" / "meshmark" / "data" / "hare.xz"


def build() -> tuple[Array, Faces, Array]:
    """Return vertices in mm, faces, and 8-bit colours of the hare."""
    vertices, faces = extract(hare.hare, hare.LOW, hare.HIGH, CELL)
    vertices, faces = settle(hare.hare, vertices, faces, CELL, ROUNDS)
    check(faces)
    normals = gradient(hare.hare, vertices, 0.2 * CELL)
    colours = np.rint(255 * np.clip(hare.colour(vertices, normals), 0, 1)).astype(np.uint8)
    vertices = vertices + hare.relief(vertices)[:, None] * normals
    faces = np.array([np.roll(face, -face.argmin()) for face in faces])
    return np.rint(vertices * MILLIMETRES / GRID) * GRID, faces[np.lexsort(faces.T[::-1])], colours


def check(faces: Faces) -> None:
    """Stop where an edge does not join exactly two triangles."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if (np.unique(edges, axis=0, return_counts=True)[1] != 2).any():
        raise SystemExit("the surface is not a closed manifold: give the parts rounder joints or change CELL")


def ply(vertices: Array, faces: Faces, colours: Array) -> bytes:
    """Return a binary PLY file: float positions, colours, triangles."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        "comment The meshmark hare, made by tools/make_demo_model.py, MIT\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(vertices), [("position", "<f4", 3), ("colour", "u1", 3)])
    rows["position"], rows["colour"] = vertices, colours
    triangles = np.empty(len(faces), [("count", "u1"), ("index", "<i4", 3)])
    triangles["count"], triangles["index"] = 3, faces
    return header.encode() + rows.tobytes() + triangles.tobytes()


if __name__ == "__main__":
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else HOME
    vertices, triangles, colours = build()
    out.write_bytes(packed(ply(vertices, triangles, colours), len(triangles)))
    print(f"{out}: {out.stat().st_size:,} bytes")

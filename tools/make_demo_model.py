"""Make the model that `meshmark demo` marks: src/meshmark/data/hare.drc. The same bytes on every run.

.venv/bin/python tools/make_demo_model.py [OUT.drc]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from demo_model import hare
from demo_model.surface import extract, gradient, settle

from meshmark.data.packing import Colours, Faces, Points, packed

CELL = 0.034
ROUNDS = 15
MILLIMETRES = 30.0
# Colours in steps that fur and grass hide take a third of the bytes.
SHADES = 17
# Positions on a fine grid of millimetres are packed without loss.
STEP = 2.0**-9
HOME = Path(__file__).resolve().parents[1] / "src" / "meshmark" / "data" / "hare.drc"


def build() -> tuple[Points, Faces, Colours]:
    """Return vertices in mm, faces, and 8-bit colours of the hare."""
    vertices, faces = extract(hare.hare, hare.LOW, hare.HIGH, CELL)
    vertices, faces = settle(hare.hare, vertices, faces, CELL, ROUNDS)
    check(faces)
    normals = gradient(hare.hare, vertices, 0.2 * CELL)
    shades = np.rint(SHADES * np.clip(hare.colour(vertices, normals), 0, 1))
    colours = (255 // SHADES * shades).astype(np.uint8)
    vertices = vertices + hare.relief(vertices)[:, None] * normals
    positions = (np.rint(vertices * MILLIMETRES / STEP) * STEP + 0.0).astype(np.float32)  # no negative zeros
    return positions, sorted_faces(faces.astype(np.int32)), colours


def sorted_faces(faces: Faces) -> Faces:
    """Return the faces (m, 3) in order, each turned so that its lowest corner comes first."""
    turns = (np.arange(3) + faces.argmin(axis=1)[:, None]) % 3
    turned: Faces = np.take_along_axis(faces, turns, axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def check(faces: Faces) -> None:
    """Stop where an edge does not join exactly two triangles."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if (np.unique(edges, axis=0, return_counts=True)[1] != 2).any():
        raise SystemExit("the surface is not a closed manifold: give the parts rounder joints or change CELL")


if __name__ == "__main__":
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else HOME
    vertices, triangles, colours = build()
    out.write_bytes(packed(vertices, triangles, colours, STEP))
    print(f"{out}: {out.stat().st_size:,} bytes")
